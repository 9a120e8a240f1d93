/// Types of fixed shape that a State holds as arrays of numbers: numbers, enumerations, fixed Eigen matrices, poses
/// in space, and std::array of them. Each trait states the number type, the shape of one value, and the lossless
/// conversion between a value and `kCount` numbers.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <vector>

namespace ratslam {

using StateShape = std::vector<std::uint64_t>;

/// Types without a specialisation below are not plain.
template <class T, class Enable = void>
struct StatePlain {
  static constexpr bool kIs = false;
};

template <class T>
struct StatePlain<T, std::enable_if_t<std::is_arithmetic_v<T> || std::is_enum_v<T>>> {
  static constexpr bool kIs = true;
  static constexpr std::size_t kCount = 1;
  template <class U, bool IsEnum>
  struct Number {
    using Type = U;
  };
  template <class U>
  struct Number<U, true> {
    using Type = std::underlying_type_t<U>;
  };
  using Scalar =
      std::conditional_t<std::is_same_v<T, bool>, std::uint8_t, typename Number<T, std::is_enum_v<T>>::Type>;
  static StateShape shape() { return {}; }
  static void write(const T& value, Scalar* numbers) { *numbers = static_cast<Scalar>(value); }
  static void read(const Scalar* numbers, T& value) { value = static_cast<T>(*numbers); }
};

template <class S, int Rows, int Columns, int Options>
struct StatePlain<Eigen::Matrix<S, Rows, Columns, Options>,
                  std::enable_if_t<Rows != Eigen::Dynamic && Columns != Eigen::Dynamic>> {
  using Matrix = Eigen::Matrix<S, Rows, Columns, Options>;
  using Scalar = S;
  static constexpr bool kIs = true;
  static constexpr std::size_t kCount = static_cast<std::size_t>(Rows) * static_cast<std::size_t>(Columns);
  static StateShape shape() {
    return {static_cast<std::uint64_t>(Rows), static_cast<std::uint64_t>(Columns)};
  }
  static void write(const Matrix& value, Scalar* numbers) {
    for (int row = 0; row < Rows; ++row) {
      for (int column = 0; column < Columns; ++column) *numbers++ = value(row, column);
    }
  }
  static void read(const Scalar* numbers, Matrix& value) {
    for (int row = 0; row < Rows; ++row) {
      for (int column = 0; column < Columns; ++column) value(row, column) = *numbers++;
    }
  }
};

template <>
struct StatePlain<Eigen::Isometry3d> {
  using Scalar = double;
  using Matrix = StatePlain<Eigen::Matrix4d>;
  static constexpr bool kIs = true;
  static constexpr std::size_t kCount = Matrix::kCount;
  static StateShape shape() { return Matrix::shape(); }
  static void write(const Eigen::Isometry3d& value, Scalar* numbers) {
    Matrix::write(value.matrix(), numbers);
  }
  static void read(const Scalar* numbers, Eigen::Isometry3d& value) { Matrix::read(numbers, value.matrix()); }
};

/// As (x, y, z, w).
template <>
struct StatePlain<Eigen::Quaterniond> {
  using Scalar = double;
  using Matrix = StatePlain<Eigen::Vector4d>;
  static constexpr bool kIs = true;
  static constexpr std::size_t kCount = Matrix::kCount;
  static StateShape shape() { return Matrix::shape(); }
  static void write(const Eigen::Quaterniond& value, Scalar* numbers) {
    Matrix::write(value.coeffs(), numbers);
  }
  static void read(const Scalar* numbers, Eigen::Quaterniond& value) {
    Matrix::read(numbers, value.coeffs());
  }
};

template <class T, std::size_t Size>
struct StatePlain<std::array<T, Size>, std::enable_if_t<StatePlain<T>::kIs>> {
  using Element = StatePlain<T>;
  using Scalar = typename Element::Scalar;
  static constexpr bool kIs = true;
  static constexpr std::size_t kCount = Size * Element::kCount;
  static StateShape shape() {
    StateShape shape = Element::shape();
    shape.insert(shape.begin(), Size);
    return shape;
  }
  static void write(const std::array<T, Size>& value, Scalar* numbers) {
    for (std::size_t i = 0; i < Size; ++i) Element::write(value[i], numbers + i * Element::kCount);
  }
  static void read(const Scalar* numbers, std::array<T, Size>& value) {
    for (std::size_t i = 0; i < Size; ++i) Element::read(numbers + i * Element::kCount, value[i]);
  }
};

}  // namespace ratslam
