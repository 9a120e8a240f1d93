/// Serialised state of a part of the system. Reading restores every bit.
///
/// A State is a tree of names. Each name holds an array of numbers (type, shape, bytes) or another State. A State
/// with rows is a table: its arrays are columns with one entry per row. A column whose entries have different
/// lengths stores where each one ends. A map file (system/map_store.h) keeps States on disk.
///
/// An object is written and read by the same list of fields:
///
///     template <class Fields>
///     void stateFields(Fields&& fields) {          // for reading and writing, hence not const
///       fields("speed", speed_);                   // numbers, enumerations, strings, Eigen matrices
///       fields("history", history_);               // std::vector or std::deque of these
///       fields("last", last_);                     // std::optional of any of these
///       fields("links", links_);                   // std::vector of structs with stateFields: a table
///     }
///     void save(State& state) const { state.write(*this); }
///     void load(const State& state) { state.read(*this); }
///
/// Anything else uses set() and get(). A missing name, and a value of another type or shape, are errors that name
/// it.
///
/// Saving must be fast for the stage. Tables, and values of setLater(), are stored as copies of the objects and are
/// converted when they are first read. So if a State is handed to another thread, that thread does most of the work.
#pragma once

#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "ratslam/common/state_plain.h"

namespace ratslam {

enum class StateType : std::uint8_t {
  kInt8 = 0,
  kUint8 = 1,
  kInt16 = 2,
  kUint16 = 3,
  kInt32 = 4,
  kUint32 = 5,
  kInt64 = 6,
  kUint64 = 7,
  kFloat32 = 8,
  kFloat64 = 9,
};

/// "uint8", "float64", ...
const char* stateTypeName(StateType type);
/// Bytes of one number. @throws std::runtime_error for an invalid type
std::size_t stateTypeSize(StateType type);

template <class Scalar>
constexpr StateType stateTypeOf() {
  if constexpr (std::is_same_v<Scalar, float>) return StateType::kFloat32;
  if constexpr (std::is_same_v<Scalar, double>) return StateType::kFloat64;
  if constexpr (std::is_integral_v<Scalar>) {
    constexpr int kLogSize = sizeof(Scalar) == 1 ? 0 : sizeof(Scalar) == 2 ? 1 : sizeof(Scalar) == 4 ? 2 : 3;
    return static_cast<StateType>(2 * kLogSize + (std::is_unsigned_v<Scalar> ? 1 : 0));
  }
}

/// An array of numbers in row-major order, in the byte order of the machine (little-endian).
struct StateArray {
  StateType type = StateType::kUint8;
  StateShape shape;
  std::vector<std::uint8_t> bytes;
  /// For a column whose entries have different lengths: the end of each entry, in numbers. Else empty.
  std::vector<std::uint64_t> ends;

  bool operator==(const StateArray& other) const {
    return type == other.type && shape == other.shape && bytes == other.bytes && ends == other.ends;
  }
};

class State {
 public:
  bool operator==(const State& other) const {
    return rows_ == other.rows_ && arrays_ == other.arrays_ && children() == other.children();
  }

  /// The child of this name. It is created if it is missing.
  State& child(const std::string& name);
  /// @throws std::runtime_error naming the child if it is missing
  const State& child(const std::string& name) const;
  /// The State below this one at names joined by '/': "experience_map/graph". Null if it is missing.
  const State* find(const std::string& path) const;
  bool hasChild(const std::string& name) const { return children_.count(name) + later_.count(name) > 0; }
  /// Stores a child that is computed when it is first read, in any thread. Replaces the entry of that name.
  /// @param fill  must own everything that it uses
  void setLater(const std::string& name, std::function<void(State&)> fill);

  /// Stores a value of a type that stateFields may list. Replaces the entry of that name.
  template <class T>
  void set(const std::string& name, const T& value);
  /// Reads a value into a variable of the same type.
  /// @throws std::runtime_error naming what is missing or of another type or shape
  template <class T>
  void get(const std::string& name, T& value) const;
  template <class T>
  T get(const std::string& name) const {
    T value{};
    get(name, value);
    return value;
  }

  /// Stores or reads all fields that an object lists in stateFields.
  template <class Object>
  void write(const Object& object);
  template <class Object>
  void read(Object& object) const;

  /// Stores the elements of a list as children named by their numbers, for elements that cannot be rows.
  template <class Object>
  void setEach(const std::string& name, const std::vector<Object>& objects);
  /// Calls load(state, number) for each element of the list. @return how many there are
  template <class Load>
  std::size_t forEach(const std::string& name, Load&& load) const;

  /// Stores the version of a part's layout. A part must refuse an unknown version.
  void setVersion(std::uint32_t version) { set("version", version); }
  /// @throws std::runtime_error naming the part if it has another version
  void requireVersion(std::uint32_t version) const;

  // The following functions are for storing States.
  const std::map<std::string, StateArray>& arrays() const { return arrays_; }
  const std::map<std::string, State>& children() const;
  /// @throws std::runtime_error if bytes or rows do not fit type and shape
  void setArray(const std::string& name, StateArray array);
  /// @throws std::runtime_error naming the array if it is missing
  const StateArray& array(const std::string& name) const;
  /// Number of rows if this State is a table.
  const std::optional<std::uint64_t>& rows() const { return rows_; }
  void setRows(std::uint64_t rows) { rows_ = rows; }
  /// Names from the root to this State, "experience_map/graph"; for messages.
  const std::string& path() const { return path_; }

  /// The whole tree as bytes.
  std::vector<std::uint8_t> toBytes() const;
  /// @throws std::runtime_error if the bytes are not those of toBytes()
  static State fromBytes(const std::vector<std::uint8_t>& bytes);

 private:
  [[noreturn]] void fail(const std::string& name, const std::string& what) const;
  const StateArray& arrayOf(const std::string& name, StateType type, const StateShape& element,
                            std::size_t leading) const;
  static void append(const State& state, std::vector<std::uint8_t>& bytes);
  static void takeInto(const std::vector<std::uint8_t>& bytes, std::size_t& position, State& state,
                       int depth);

  /// Replaces the entry of that name by an empty child.
  State& emptyChild(const std::string& name);
  /// Computes a child of setLater() if it has not been computed yet.
  void make(const std::string& name) const;
  template <class Element>
  void setRowsOf(const std::string& name, std::vector<Element> elements);
  template <class Element>
  void getRowsOf(const std::string& name, std::vector<Element>& elements) const;

  std::string path_;
  std::map<std::string, StateArray> arrays_;
  mutable std::map<std::string, State> children_;
  mutable std::map<std::string, std::function<void(State&)>> later_;  // children that are not computed yet
  std::optional<std::uint64_t> rows_;
};

}  // namespace ratslam

#include "ratslam/common/state_fields.h"
