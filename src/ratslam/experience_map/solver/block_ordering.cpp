#include "ratslam/experience_map/solver/block_ordering.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>
#include <algorithm>
#include <numeric>

namespace ratslam {
namespace {

using Edge = std::pair<std::uint32_t, std::uint32_t>;

/// Marks the unknowns with other neighbours than their predecessor and successor.
std::vector<char> findJunctions(std::uint32_t unknowns, const std::vector<Edge>& edges) {
  std::vector<char> junction(unknowns, 0);
  for (const Edge& edge : edges) {
    const auto [low, high] = std::minmax(edge.first, edge.second);
    if (high - low > 1) junction[low] = junction[high] = 1;
  }
  return junction;
}

/// Edges in compressed columns: for each column the rows below the diagonal.
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

/// The junctions in their order of elimination. @param index_of_junction of each unknown. @param edges between
/// junctions, after elimination of the chains.
std::vector<std::uint32_t> orderJunctions(const std::vector<std::uint32_t>& junctions,
                                          const std::vector<std::uint32_t>& index_of_junction,
                                          const std::vector<Edge>& edges) {
  // Fills one half of the symmetric pattern column by column. Eigen's triplets would take longer than the
  // ordering.
  using Pattern = Eigen::SparseMatrix<float>;
  const auto size = static_cast<Eigen::Index>(junctions.size());
  Adjacency adjacency = listEdges(index_of_junction, edges);
  Pattern pattern(size, size);
  pattern.reserve(size + static_cast<Eigen::Index>(edges.size()));
  for (Eigen::Index column = 0; column < size; ++column) {
    const auto rows = adjacency.rows.begin();
    const auto begin = rows + static_cast<std::ptrdiff_t>(adjacency.begin[static_cast<std::size_t>(column)]);
    auto end = rows + static_cast<std::ptrdiff_t>(adjacency.begin[static_cast<std::size_t>(column) + 1]);
    std::sort(begin, end);
    end = std::unique(begin, end);
    pattern.startVec(column);
    pattern.insertBack(column, column) = 1.0F;
    for (auto row = begin; row != end; ++row) pattern.insertBack(*row, column) = 1.0F;
  }
  pattern.finalize();
  Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> elimination;
  Eigen::AMDOrdering<int>()(pattern.selfadjointView<Eigen::Lower>(), elimination);
  std::vector<std::uint32_t> order;
  order.reserve(junctions.size());
  for (Eigen::Index k = 0; k < size; ++k) {
    order.push_back(junctions[static_cast<std::size_t>(elimination.indices()[k])]);
  }
  return order;
}

/// Finds for each column the non-zero rows below the diagonal, fill-in included, ascending.
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
  const std::vector<char> junction = findJunctions(unknowns, edges);
  std::vector<std::uint32_t> junctions;
  std::vector<std::uint32_t> order;
  order.reserve(unknowns);
  std::vector<Edge> remaining;
  std::vector<std::uint32_t> index_of_junction(unknowns, 0);
  for (std::uint32_t unknown = 0; unknown < unknowns; ++unknown) {
    if (junction[unknown] == 0) {
      order.push_back(unknown);
      continue;
    }
    index_of_junction[unknown] = static_cast<std::uint32_t>(junctions.size());
    // Elimination of a chain joins the junctions at its ends.
    if (!junctions.empty()) remaining.emplace_back(junctions.back(), unknown);
    junctions.push_back(unknown);
  }
  for (const Edge& edge : edges) {
    if (junction[edge.first] != 0 && junction[edge.second] != 0) remaining.push_back(edge);
  }
  const std::vector<std::uint32_t> last = orderJunctions(junctions, index_of_junction, remaining);
  order.insert(order.end(), last.begin(), last.end());

  BlockStructure structure;
  structure.position.resize(unknowns);
  for (std::uint32_t k = 0; k < unknowns; ++k) structure.position[order[k]] = k;
  eliminateSymbolically(listEdges(structure.position, edges), structure);
  return structure;
}

}  // namespace ratslam
