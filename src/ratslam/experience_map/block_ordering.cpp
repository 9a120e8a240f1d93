#include "ratslam/experience_map/block_ordering.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace ratslam {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Unknowns that have other neighbours than their predecessor and successor.
std::vector<bool> findJunctions(std::uint32_t unknowns, const std::vector<Edge>& edges) {
  std::vector<bool> junction(unknowns, false);
  for (const Edge& edge : edges) {
    const auto [low, high] = std::minmax(edge.first, edge.second);
    if (high - low > 1) junction[low] = junction[high] = true;
  }
  return junction;
}

/// Junctions in the order of their elimination, given the edges between them that remain once chains are
/// eliminated.
std::vector<std::uint32_t> orderJunctions(const std::vector<std::uint32_t>& junctions,
                                          const std::vector<Edge>& edges) {
  using Pattern = Eigen::SparseMatrix<double>;
  const auto size = static_cast<Eigen::Index>(junctions.size());
  const auto indexOf = [&](std::uint32_t unknown) {
    return static_cast<int>(std::lower_bound(junctions.begin(), junctions.end(), unknown) -
                            junctions.begin());
  };
  std::vector<Eigen::Triplet<double>> entries;
  for (int k = 0; k < size; ++k) entries.emplace_back(k, k, 1.0);
  for (const Edge& edge : edges) {
    const int a = indexOf(edge.first);
    const int b = indexOf(edge.second);
    entries.emplace_back(a, b, 1.0);
    entries.emplace_back(b, a, 1.0);
  }
  Pattern pattern(size, size);
  pattern.setFromTriplets(entries.begin(), entries.end());
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> elimination;
  Eigen::AMDOrdering<int>()(pattern, elimination);
  std::vector<std::uint32_t> order;
  for (Eigen::Index k = 0; k < size; ++k) {
    order.push_back(junctions[static_cast<std::size_t>(elimination.indices()[k])]);
  }
  return order;
}

/// Edges as lists: for each column the rows below the diagonal, one after the other.
struct Adjacency {
  std::vector<std::size_t> begin;
  std::vector<std::uint32_t> rows;
};

Adjacency listEdges(const std::vector<std::uint32_t>& position, const std::vector<Edge>& edges) {
  Adjacency adjacency;
  adjacency.begin.assign(position.size() + 1, 0);
  const auto low = [&](const Edge& edge) { return std::min(position[edge.first], position[edge.second]); };
  for (const Edge& edge : edges) ++adjacency.begin[low(edge) + 1];
  std::partial_sum(adjacency.begin.begin(), adjacency.begin.end(), adjacency.begin.begin());
  adjacency.rows.resize(edges.size());
  std::vector<std::size_t> next(adjacency.begin.begin(), adjacency.begin.end() - 1);
  for (const Edge& edge : edges) {
    adjacency.rows[next[low(edge)]++] = std::max(position[edge.first], position[edge.second]);
  }
  return adjacency;
}

/// For each column the rows below the diagonal that fill in, ascending.
void eliminateSymbolically(const Adjacency& adjacency, BlockStructure& structure) {
  const auto columns = static_cast<std::uint32_t>(structure.position.size());
  const std::uint32_t none = columns;
  structure.column_begin.assign(1, 0);
  structure.column_begin.reserve(columns + 1);
  structure.rows.reserve(3 * adjacency.rows.size());
  // Children in the elimination tree, as lists threaded through the columns.
  std::vector<std::uint32_t> first_child(columns, none);
  std::vector<std::uint32_t> next_sibling(columns, none);
  std::vector<std::uint32_t> seen_by(columns, none);
  for (std::uint32_t column = 0; column < columns; ++column) {
    const std::size_t begin = structure.rows.size();
    const auto take = [&](std::uint32_t row) {
      if (row > column && seen_by[row] != column) {
        seen_by[row] = column;
        structure.rows.push_back(row);
      }
    };
    for (std::size_t k = adjacency.begin[column]; k < adjacency.begin[column + 1]; ++k)
      take(adjacency.rows[k]);
    for (std::uint32_t child = first_child[column]; child != none; child = next_sibling[child]) {
      for (std::size_t k = structure.column_begin[child]; k < structure.column_begin[child + 1]; ++k) {
        take(structure.rows[k]);
      }
    }
    std::sort(structure.rows.begin() + static_cast<std::ptrdiff_t>(begin), structure.rows.end());
    structure.column_begin.push_back(structure.rows.size());
    if (structure.rows.size() > begin) {
      const std::uint32_t parent = structure.rows[begin];
      next_sibling[column] = first_child[parent];
      first_child[parent] = column;
    }
  }
}

}  // namespace

std::size_t BlockStructure::find(std::uint32_t row, std::uint32_t column) const {
  const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(column_begin[column]);
  const auto end = rows.begin() + static_cast<std::ptrdiff_t>(column_begin[column + 1]);
  return static_cast<std::size_t>(std::lower_bound(begin, end, row) - rows.begin());
}

BlockStructure orderBlocks(std::uint32_t unknowns, const std::vector<Edge>& edges) {
  const std::vector<bool> junction = findJunctions(unknowns, edges);
  std::vector<std::uint32_t> junctions;
  std::vector<std::uint32_t> order;
  std::vector<Edge> remaining;
  for (std::uint32_t unknown = 0; unknown < unknowns; ++unknown) {
    if (!junction[unknown]) {
      order.push_back(unknown);
      continue;
    }
    // A chain that has been eliminated joins the junctions at its ends.
    if (!junctions.empty()) remaining.emplace_back(junctions.back(), unknown);
    junctions.push_back(unknown);
  }
  for (const Edge& edge : edges) {
    if (junction[edge.first] && junction[edge.second]) remaining.push_back(edge);
  }
  const std::vector<std::uint32_t> last = orderJunctions(junctions, remaining);
  order.insert(order.end(), last.begin(), last.end());

  BlockStructure structure;
  structure.position.resize(unknowns);
  for (std::uint32_t k = 0; k < unknowns; ++k) structure.position[order[k]] = k;
  eliminateSymbolically(listEdges(structure.position, edges), structure);
  return structure;
}

}  // namespace ratslam
