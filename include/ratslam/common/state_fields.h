/// Conversion between values and arrays of a State. Only state.h includes it.
#pragma once

#include "ratslam/common/state.h"

namespace ratslam {
namespace state_detail {

/// A visitor that does nothing, for testing whether a type has stateFields.
struct NoFields {
  template <class T>
  void operator()(const char*, T&) const {}
};

template <class T, class = void>
struct HasFields : std::false_type {};
template <class T>
struct HasFields<T, std::void_t<decltype(std::declval<T&>().stateFields(NoFields{}))>> : std::true_type {};

template <class T>
struct ListOf {
  static constexpr bool kIs = false;
};
template <class T, class A>
struct ListOf<std::vector<T, A>> {
  static constexpr bool kIs = true;
  using Element = T;
};
template <class T, class A>
struct ListOf<std::deque<T, A>> {
  static constexpr bool kIs = true;
  using Element = T;
};

template <class T>
struct OptionalOf {
  static constexpr bool kIs = false;
};
template <class T>
struct OptionalOf<std::optional<T>> {
  static constexpr bool kIs = true;
  using Element = T;
};

template <class T>
struct IsDynamicMatrix : std::false_type {};
template <class S, int Rows, int Columns, int Options>
struct IsDynamicMatrix<Eigen::Matrix<S, Rows, Columns, Options>>
    : std::bool_constant<Rows == Eigen::Dynamic || Columns == Eigen::Dynamic> {};

/// The numbers of a list of plain values, one after another.
template <class List>
void appendNumbers(const List& list, std::vector<std::uint8_t>& bytes) {
  using Plain = StatePlain<typename ListOf<List>::Element>;
  using Scalar = typename Plain::Scalar;
  constexpr std::size_t kSize = Plain::kCount * sizeof(Scalar);
  std::size_t position = bytes.size();
  bytes.resize(position + list.size() * kSize);
  Scalar numbers[Plain::kCount];
  for (const auto& value : list) {
    Plain::write(value, numbers);
    std::memcpy(bytes.data() + position, numbers, kSize);
    position += kSize;
  }
}

template <class T>
void takeNumbers(const std::uint8_t* bytes, T& value) {
  using Plain = StatePlain<T>;
  typename Plain::Scalar numbers[Plain::kCount];
  std::memcpy(numbers, bytes, sizeof numbers);
  Plain::read(numbers, value);
}

/// The entry of a row for a missing optional value.
template <class T>
T zero() {
  T value{};
  if constexpr (StatePlain<T>::kIs) {
    const typename StatePlain<T>::Scalar numbers[StatePlain<T>::kCount] = {};
    StatePlain<T>::read(numbers, value);
  }
  return value;
}

/// Writes the fields of one object after another as rows of a table.
class RowWriter {
 public:
  /// The fields that follow belong to the next row.
  void nextRow() { next_ = 0; }

  template <class T>
  void operator()(const std::string& name, const T& value) {
    if constexpr (OptionalOf<T>::kIs) {
      (*this)(name + "_known", value.has_value());
      (*this)(name, value ? *value : zero<typename OptionalOf<T>::Element>());
    } else if constexpr (HasFields<T>::value) {
      const std::string outer = std::exchange(prefix_, prefix_ + name + "_");
      const_cast<T&>(value).stateFields(*this);
      prefix_ = outer;
    } else if constexpr (ListOf<T>::kIs) {
      using Plain = StatePlain<typename ListOf<T>::Element>;
      StateArray& array = column<Plain>(name);
      appendNumbers(value, array.bytes);
      array.ends.push_back(array.bytes.size() / sizeof(typename Plain::Scalar));
    } else {
      using Plain = StatePlain<T>;
      StateArray& array = column<Plain>(name);
      typename Plain::Scalar numbers[Plain::kCount];
      Plain::write(value, numbers);
      const std::size_t position = array.bytes.size();
      array.bytes.resize(position + sizeof numbers);
      std::memcpy(array.bytes.data() + position, numbers, sizeof numbers);
    }
  }

  /// Moves the columns into a table of `rows` rows.
  void finish(State& table, std::uint64_t rows);

 private:
  template <class Plain>
  StateArray& column(const std::string& name) {
    if (next_ == columns_.size()) {
      StateArray array;
      array.type = stateTypeOf<typename Plain::Scalar>();
      array.shape = Plain::shape();
      columns_.emplace_back(prefix_ + name, std::move(array));
    }
    return columns_[next_++].second;
  }

  std::vector<std::pair<std::string, StateArray>> columns_;
  std::size_t next_ = 0;
  std::string prefix_;
};

/// Reads rows back into objects.
class RowReader {
 public:
  explicit RowReader(const State& table) : table_(table) {}

  void setRow(std::size_t row) {
    row_ = row;
    next_ = 0;
  }

  template <class T>
  void operator()(const std::string& name, T& value) {
    if constexpr (OptionalOf<T>::kIs) {
      bool known = false;
      auto element = zero<typename OptionalOf<T>::Element>();
      (*this)(name + "_known", known);
      (*this)(name, element);
      value.reset();
      if (known) value = element;
    } else if constexpr (HasFields<T>::value) {
      const std::string outer = std::exchange(prefix_, prefix_ + name + "_");
      value.stateFields(*this);
      prefix_ = outer;
    } else if constexpr (ListOf<T>::kIs) {
      using Plain = StatePlain<typename ListOf<T>::Element>;
      const StateArray& array = column<Plain>(name, true);
      const std::uint64_t begin = row_ == 0 ? 0 : array.ends[row_ - 1];
      value.resize((array.ends[row_] - begin) / Plain::kCount);
      const std::uint8_t* bytes = array.bytes.data() + begin * sizeof(typename Plain::Scalar);
      for (auto& element : value) {
        takeNumbers(bytes, element);
        bytes += Plain::kCount * sizeof(typename Plain::Scalar);
      }
    } else {
      using Plain = StatePlain<T>;
      const StateArray& array = column<Plain>(name, false);
      takeNumbers(array.bytes.data() + row_ * Plain::kCount * sizeof(typename Plain::Scalar), value);
    }
  }

 private:
  template <class Plain>
  const StateArray& column(const std::string& name, bool ragged) {
    if (next_ == columns_.size()) {
      columns_.push_back(
          &find(prefix_ + name, stateTypeOf<typename Plain::Scalar>(), Plain::shape(), ragged));
    }
    return *columns_[next_++];
  }
  const StateArray& find(const std::string& name, StateType type, const StateShape& element,
                         bool ragged) const;

  const State& table_;
  std::size_t row_ = 0;
  std::vector<const StateArray*> columns_;
  std::size_t next_ = 0;
  std::string prefix_;
};

}  // namespace state_detail

template <class T>
void State::set(const std::string& name, const T& value) {
  using namespace state_detail;
  if constexpr (StatePlain<T>::kIs) {
    using Plain = StatePlain<T>;
    StateArray array{stateTypeOf<typename Plain::Scalar>(), Plain::shape(), {}, {}};
    appendNumbers(std::vector<T>{value}, array.bytes);
    setArray(name, std::move(array));
  } else if constexpr (std::is_same_v<T, std::string>) {
    setArray(name, {StateType::kUint8, {value.size()}, {value.begin(), value.end()}, {}});
  } else if constexpr (OptionalOf<T>::kIs) {
    State& optional = emptyChild(name);
    if (value) optional.set("value", *value);
  } else if constexpr (IsDynamicMatrix<T>::value) {
    std::vector<typename T::Scalar> numbers;
    for (Eigen::Index row = 0; row < value.rows(); ++row) {
      for (Eigen::Index column = 0; column < value.cols(); ++column) numbers.push_back(value(row, column));
    }
    StateArray array{stateTypeOf<typename T::Scalar>(),
                     {static_cast<std::uint64_t>(value.rows()), static_cast<std::uint64_t>(value.cols())},
                     {},
                     {}};
    appendNumbers(numbers, array.bytes);
    setArray(name, std::move(array));
  } else if constexpr (ListOf<T>::kIs) {
    using Element = typename ListOf<T>::Element;
    if constexpr (StatePlain<Element>::kIs) {
      using Plain = StatePlain<Element>;
      StateArray array{stateTypeOf<typename Plain::Scalar>(), Plain::shape(), {}, {}};
      array.shape.insert(array.shape.begin(), value.size());
      appendNumbers(value, array.bytes);
      setArray(name, std::move(array));
    } else {
      setRowsOf(name, std::vector<Element>(value.begin(), value.end()));
    }
  } else {
    static_assert(HasFields<T>::value, "a State holds plain values, lists of them, and what has stateFields");
    emptyChild(name).write(value);
  }
}

template <class T>
void State::get(const std::string& name, T& value) const {
  using namespace state_detail;
  if constexpr (StatePlain<T>::kIs) {
    using Plain = StatePlain<T>;
    takeNumbers(arrayOf(name, stateTypeOf<typename Plain::Scalar>(), Plain::shape(), 0).bytes.data(), value);
  } else if constexpr (std::is_same_v<T, std::string>) {
    const StateArray& array = arrayOf(name, StateType::kUint8, {}, 1);
    value.assign(array.bytes.begin(), array.bytes.end());
  } else if constexpr (OptionalOf<T>::kIs) {
    const State& optional = child(name);
    value.reset();
    if (!optional.arrays_.empty() || !optional.children().empty()) {
      // clang cannot emplace a nested class with default member initialisers
      typename T::value_type inside{};
      optional.get("value", inside);
      value = std::move(inside);
    }
  } else if constexpr (IsDynamicMatrix<T>::value) {
    const StateArray& array = arrayOf(name, stateTypeOf<typename T::Scalar>(), {}, 2);
    const auto rows = static_cast<Eigen::Index>(array.shape[0]);
    const auto columns = static_cast<Eigen::Index>(array.shape[1]);
    if ((T::RowsAtCompileTime != Eigen::Dynamic && T::RowsAtCompileTime != rows) ||
        (T::ColsAtCompileTime != Eigen::Dynamic && T::ColsAtCompileTime != columns)) {
      fail(name, "it has another shape");
    }
    value.resize(rows, columns);
    const std::uint8_t* bytes = array.bytes.data();
    for (Eigen::Index row = 0; row < rows; ++row) {
      for (Eigen::Index column = 0; column < columns; ++column) {
        takeNumbers(bytes, value(row, column));
        bytes += sizeof(typename T::Scalar);
      }
    }
  } else if constexpr (ListOf<T>::kIs) {
    using Element = typename ListOf<T>::Element;
    if constexpr (StatePlain<Element>::kIs) {
      using Plain = StatePlain<Element>;
      const StateArray& array = arrayOf(name, stateTypeOf<typename Plain::Scalar>(), Plain::shape(), 1);
      T elements(array.shape[0]);
      const std::uint8_t* bytes = array.bytes.data();
      for (auto& element : elements) {
        takeNumbers(bytes, element);
        bytes += Plain::kCount * sizeof(typename Plain::Scalar);
      }
      value = std::move(elements);
    } else {
      std::vector<Element> elements;
      getRowsOf(name, elements);
      value = T(elements.begin(), elements.end());
    }
  } else {
    child(name).read(value);
  }
}

template <class Object>
void State::write(const Object& object) {
  const_cast<Object&>(object).stateFields(
      [this](const std::string& name, const auto& value) { this->set(name, value); });
}

template <class Object>
void State::read(Object& object) const {
  object.stateFields([this](const std::string& name, auto& value) { this->get(name, value); });
}

template <class Element>
void State::setRowsOf(const std::string& name, std::vector<Element> elements) {
  static_assert(state_detail::HasFields<Element>::value, "elements of a list are plain or have stateFields");
  setLater(name, [rows = std::make_shared<std::vector<Element>>(std::move(elements))](State& table) {
    state_detail::RowWriter writer;
    for (Element& element : *rows) {
      writer.nextRow();
      element.stateFields(writer);
    }
    writer.finish(table, rows->size());
  });
}

template <class Element>
void State::getRowsOf(const std::string& name, std::vector<Element>& elements) const {
  const State& table = child(name);
  if (!table.rows_) fail(name, "it is no table");
  std::vector<Element> read(*table.rows_);
  state_detail::RowReader reader(table);
  for (std::size_t row = 0; row < read.size(); ++row) {
    reader.setRow(row);
    read[row].stateFields(reader);
  }
  elements = std::move(read);
}

template <class Object>
void State::setEach(const std::string& name, const std::vector<Object>& objects) {
  State& list = emptyChild(name);
  list.set("count", static_cast<std::uint64_t>(objects.size()));
  for (std::size_t i = 0; i < objects.size(); ++i) objects[i].save(list.child(std::to_string(i)));
}

template <class Load>
std::size_t State::forEach(const std::string& name, Load&& load) const {
  const State& list = child(name);
  const auto count = static_cast<std::size_t>(list.get<std::uint64_t>("count"));
  for (std::size_t i = 0; i < count; ++i) load(list.child(std::to_string(i)), i);
  return count;
}

}  // namespace ratslam
