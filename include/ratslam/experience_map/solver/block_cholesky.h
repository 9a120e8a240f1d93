/// Sparse Cholesky factorisation H = L D L^T in dense blocks of fixed size. It can be done in slices.
///
/// H is symmetric and positive definite. orderBlocks() gives the structure of L. Columns are eliminated from left
/// to right; each one subtracts its outer product from the columns after it (right-looking). Work is counted in
/// block products, so that slices are the same on every machine.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <map>
#include <vector>

#include "ratslam/experience_map/solver/block_ordering.h"

namespace ratslam {

template <int Size>
class BlockCholesky {
 public:
  using Block = Eigen::Matrix<double, Size, Size>;
  using Vector = Eigen::Matrix<double, Size, 1>;

  /// Starts a new system of the given structure; all blocks are zero. The structure must outlive the system.
  void reset(const BlockStructure& structure) {
    structure_ = &structure;
    diagonal_.assign(structure.columns(), Block::Zero());
    below_.assign(structure.rows.size(), Block::Zero());
    next_column_ = 0;
    definite_ = true;
  }

  /// Diagonal block at a position in the order of elimination.
  Block& diagonal(std::uint32_t position) { return diagonal_[position]; }

  /// Adds to the block of two different unknowns. @param block  with row a and column b; a and b are positions
  template <class Derived>
  void addBetween(std::uint32_t a, std::uint32_t b, const Eigen::MatrixBase<Derived>& block) {
    if (a > b) {
      below_[structure_->find(a, b)] += block;
    } else {
      below_[structure_->find(b, a)] += block.transpose();
    }
  }

  /// Eliminates columns until all are done or `work` is used up. @return whether all are done.
  bool factorise(std::int64_t& work) {
    const auto columns = static_cast<std::uint32_t>(structure_->columns());
    while (next_column_ < columns && work > 0) {
      const std::size_t blocks =
          structure_->column_begin[next_column_ + 1] - structure_->column_begin[next_column_];
      eliminate(next_column_++);
      work -= static_cast<std::int64_t>(2 + blocks + blocks * (blocks + 1) / 2);
    }
    return next_column_ == columns;
  }

  /// Number of columns eliminated so far.
  std::uint32_t columnsDone() const { return next_column_; }

  /// Eliminates columns until `columns` are done.
  void factoriseUpTo(std::uint32_t columns) {
    while (next_column_ < columns) eliminate(next_column_++);
  }

  /// The diagonal block of the inverse of H at a position: the marginal covariance of that unknown. Visits only
  /// its ancestors in the elimination tree. The factorisation must be complete.
  Block inverseAt(std::uint32_t position) const {
    std::map<std::uint32_t, Block> rest{{position, Block::Identity()}};
    Block inverse = Block::Zero();
    while (!rest.empty()) {
      const auto [column, value] = *rest.begin();
      rest.erase(rest.begin());
      inverse.noalias() += value.transpose() * diagonal_[column] * value;
      const Block& known = value;
      forEachBlock(column, [&rest, &known](std::uint32_t row, const Block& block) {
        const auto [place, fresh] = rest.try_emplace(row, Block::Zero());
        place->second.noalias() -= block * known;
      });
    }
    return inverse;
  }

  /// Whether every pivot so far was positive definite.
  bool definite() const { return definite_; }

  /// Solves H x = b in place; x and b are ordered by position. The factorisation must be complete.
  void solve(std::vector<Vector>& x) const {
    const auto columns = static_cast<std::uint32_t>(structure_->columns());
    for (std::uint32_t column = 0; column < columns; ++column) {
      const Vector value = x[column];
      forEachBlock(column, [&](std::uint32_t row, const Block& block) { x[row].noalias() -= block * value; });
    }
    for (std::uint32_t column = columns; column-- > 0;) {
      Vector value = diagonal_[column] * x[column];
      forEachBlock(column, [&](std::uint32_t row, const Block& block) {
        value.noalias() -= block.transpose() * x[row];
      });
      x[column] = value;
    }
  }

 private:
  template <class Visit>
  void forEachBlock(std::uint32_t column, Visit&& visit) const {
    for (std::size_t k = structure_->column_begin[column]; k < structure_->column_begin[column + 1]; ++k) {
      visit(structure_->rows[k], below_[k]);
    }
  }

  /// Turns column `c` of H into that of L. Its diagonal block becomes the inverse of D's.
  void eliminate(std::uint32_t c) {
    definite_ = invert(diagonal_[c]) && definite_;
    const std::size_t begin = structure_->column_begin[c];
    const std::size_t end = structure_->column_begin[c + 1];
    for (std::size_t j = begin; j < end; ++j) {
      const std::uint32_t column = structure_->rows[j];
      const Block raw = below_[j];
      below_[j].noalias() = raw * diagonal_[c];
      diagonal_[column].noalias() -= below_[j] * raw.transpose();
      const Block scaled_transposed = below_[j].transpose();
      // Column `column` contains all rows of this column from j on, in the same order.
      std::size_t target = structure_->column_begin[column];
      for (std::size_t i = j + 1; i < end; ++i) {
        while (structure_->rows[target] != structure_->rows[i]) ++target;
        below_[target].noalias() -= below_[i] * scaled_transposed;
      }
    }
  }

  /// Replaces a symmetric block by its inverse, computed from its Cholesky factor. Eigen's inverse takes several
  /// times as long at these sizes. @return whether the block was positive definite.
  static bool invert(Block& block) {
    Block factor_inverse = Block::Zero();  // lower triangle
    for (int column = 0; column < Size; ++column) {
      for (int row = column; row < Size; ++row) {
        for (int k = 0; k < column; ++k) block(row, column) -= block(row, k) * block(column, k);
      }
      if (!(block(column, column) > 0.0)) return false;
      const double scale = 1.0 / std::sqrt(block(column, column));
      for (int row = column; row < Size; ++row) block(row, column) *= scale;
      factor_inverse(column, column) = scale;
      for (int k = 0; k < column; ++k) {
        double sum = 0.0;
        for (int m = k; m < column; ++m) sum += block(column, m) * factor_inverse(m, k);
        factor_inverse(column, k) = -scale * sum;
      }
    }
    block.noalias() = factor_inverse.transpose() * factor_inverse;
    return true;
  }

  const BlockStructure* structure_ = nullptr;
  std::vector<Block> diagonal_;
  std::vector<Block> below_;
  std::uint32_t next_column_ = 0;
  bool definite_ = true;
};

}  // namespace ratslam
