/// Which unknowns of a pose graph to eliminate in which order, and the block structure of the factor that
/// results.
///
/// A map is one long chain with loops. Steps:
///  1. the inner nodes of chains (joined to their predecessor and successor
///     only), in the order of the chain: each leaves two blocks below the
///     diagonal;
///  2. the remaining junctions, by approximate minimum degree (Amestoy, Davis & Duff, 1996; Eigen's
///     implementation);
///  3. symbolic elimination: the structure of a column is its own and its children's in the elimination tree
///     (Davis, Direct Methods for Sparse Linear Systems, 2006, chapter 4).
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace ratslam {

/// Block structure of a factor. Columns and rows are numbered in the order of elimination.
struct BlockStructure {
  std::vector<std::uint32_t> position;  ///< of each unknown in the order of elimination
  std::vector<std::size_t>
      column_begin;  ///< first block of each column below the diagonal; one entry more than columns
  std::vector<std::uint32_t> rows;  ///< of the blocks, ascending within a column

  std::size_t columns() const { return column_begin.empty() ? 0 : column_begin.size() - 1; }

  /// Index of a block. @param row greater than column, and part of the structure.
  std::size_t find(std::uint32_t row, std::uint32_t column) const;
};

/// @param unknowns number of unknowns. @param edges pairs of different unknowns that share a constraint.
BlockStructure orderBlocks(std::uint32_t unknowns,
                           const std::vector<std::pair<std::uint32_t, std::uint32_t>>& edges);

}  // namespace ratslam
