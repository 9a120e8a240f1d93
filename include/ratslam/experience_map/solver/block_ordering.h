/// Elimination order of the unknowns of a pose graph, and the block structure of the resulting factor.
///
/// A map is one long chain with loops. Steps:
///  1. First come the inner nodes of chains, which are joined only to their predecessor and successor. They are
///     eliminated in the order of the chain: each leaves two blocks below the diagonal.
///  2. Then come the remaining junctions, by approximate minimum degree (Amestoy, Davis & Duff, 1996; Eigen's
///     implementation).
///  3. Symbolic elimination: a column's structure is the union of its own and that of its children in the
///     elimination tree (Davis, Direct Methods for Sparse Linear Systems, 2006, chapter 4).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace ratslam {

/// Block structure of a factor. Columns and rows are numbered in the order of elimination.
struct BlockStructure {
  std::vector<std::uint32_t> position;  ///< of each unknown in the order of elimination
  /// Index of each column's first block below the diagonal; one entry more than there are columns.
  std::vector<std::size_t> column_begin;
  std::vector<std::uint32_t> rows;  ///< row of each block, ascending within a column

  std::size_t columns() const { return column_begin.empty() ? 0 : column_begin.size() - 1; }

  /// Index of a block in `rows`. @param row greater than column. The block must be part of the structure.
  std::size_t find(std::uint32_t row, std::uint32_t column) const;
};

/// @param unknowns number of unknowns. @param edges pairs of different unknowns that share a constraint.
BlockStructure orderBlocks(std::uint32_t unknowns,
                           const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges);

}  // namespace ratslam
