#include "ratslam/common/state.h"

#include <algorithm>
#include <array>

namespace ratslam {
namespace {

constexpr std::array<const char*, 10> kTypeNames{"int8",   "uint8", "int16",  "uint16",  "int32",
                                                 "uint32", "int64", "uint64", "float32", "float64"};
constexpr std::array<std::size_t, 10> kTypeSizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
constexpr std::uint64_t kMagic = 0x3145544154535352;  // "RSSTATE1" in memory
constexpr int kDeepest = 64;                          // bound on levels of States; deeper data are damaged

std::string describe(StateType type, const StateShape& shape) {
  constexpr std::size_t kMostNamed = 6;  // a damaged file may claim any number of sizes
  std::string text = stateTypeName(type);
  text += '[';
  for (std::size_t i = 0; i < std::min(shape.size(), kMostNamed); ++i)
    text += (i == 0 ? "" : " x ") + std::to_string(shape[i]);
  if (shape.size() > kMostNamed) text += " x ...: " + std::to_string(shape.size()) + " sizes";
  return text + ']';
}

/// Number of elements of an array of this shape. @throws std::runtime_error if no memory could hold it
std::uint64_t countOf(const StateShape& shape) {
  constexpr std::uint64_t kMost = std::uint64_t{1} << 40;
  std::uint64_t count = 1;
  for (const std::uint64_t size : shape) {
    if (size != 0 && count > kMost / size) throw std::runtime_error("state: an array is too large");
    count *= size;
  }
  return count;
}

template <class T>
void put(std::vector<std::uint8_t>& bytes, const T& value) {
  const std::size_t end = bytes.size();
  bytes.resize(end + sizeof value);
  std::memcpy(bytes.data() + end, &value, sizeof value);
}

void putBlock(std::vector<std::uint8_t>& bytes, const std::uint8_t* block, std::size_t size) {
  put(bytes, static_cast<std::uint64_t>(size));
  bytes.insert(bytes.end(), block, block + size);
}

void putText(std::vector<std::uint8_t>& bytes, const std::string& text) {
  putBlock(bytes, reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
}

/// Reads the data of put(). Never reads beyond the end.
class Reader {
 public:
  Reader(const std::vector<std::uint8_t>& bytes, std::size_t& position)
      : bytes_(bytes), position_(position) {}

  template <class T>
  T take() {
    T value{};
    std::memcpy(&value, claim(sizeof value), sizeof value);
    return value;
  }
  std::vector<std::uint8_t> takeBlock() {
    const auto size = take<std::uint64_t>();
    const std::uint8_t* begin = claim(size);
    return {begin, begin + size};
  }
  std::string takeName() {
    const std::vector<std::uint8_t> block = takeBlock();
    const auto printable = [](std::uint8_t c) { return c > ' ' && c < 0x7F; };
    if (block.empty() || !std::all_of(block.begin(), block.end(), printable)) {
      throw std::runtime_error("state: a name of " + std::to_string(block.size()) + " bytes is none");
    }
    return {block.begin(), block.end()};
  }
  std::vector<std::uint64_t> takeNumbers() {
    std::vector<std::uint64_t> numbers(checkedCount(sizeof(std::uint64_t)));
    for (std::uint64_t& number : numbers) number = take<std::uint64_t>();
    return numbers;
  }
  /// A count of items with at least `size` bytes each. Refuses more than fit in the rest.
  std::uint64_t checkedCount(std::size_t size) {
    const auto count = take<std::uint64_t>();
    if (count > (bytes_.size() - position_) / size) truncated();
    return count;
  }

 private:
  const std::uint8_t* claim(std::uint64_t size) {
    if (size > bytes_.size() - position_) truncated();
    const std::uint8_t* begin = bytes_.data() + position_;
    position_ += static_cast<std::size_t>(size);
    return begin;
  }
  [[noreturn]] static void truncated() { throw std::runtime_error("state: its bytes end too early"); }

  const std::vector<std::uint8_t>& bytes_;
  std::size_t& position_;
};

void putNumbers(std::vector<std::uint8_t>& bytes, const std::vector<std::uint64_t>& numbers) {
  put(bytes, static_cast<std::uint64_t>(numbers.size()));
  for (const std::uint64_t number : numbers) put(bytes, number);
}

}  // namespace

const char* stateTypeName(StateType type) {
  stateTypeSize(type);
  return kTypeNames[static_cast<std::size_t>(type)];
}

std::size_t stateTypeSize(StateType type) {
  const auto index = static_cast<std::size_t>(type);
  if (index >= kTypeSizes.size()) {
    throw std::runtime_error("state: there is no type of number " + std::to_string(index));
  }
  return kTypeSizes[index];
}

void State::fail(const std::string& name, const std::string& what) const {
  throw std::runtime_error("state " + (path_.empty() ? "" : path_ + "/") + name + ": " + what);
}

void State::setLater(const std::string& name, std::function<void(State&)> fill) {
  arrays_.erase(name);
  children_.erase(name);
  later_[name] = std::move(fill);
}

State& State::emptyChild(const std::string& name) {
  arrays_.erase(name);
  children_.erase(name);
  later_.erase(name);
  return child(name);
}

void State::make(const std::string& name) const {
  const auto found = later_.find(name);
  if (found == later_.end()) return;
  const auto waiting = later_.extract(found);  // also owns the name
  State& made = children_[waiting.key()];
  made.path_ = path_.empty() ? waiting.key() : path_ + "/" + waiting.key();
  waiting.mapped()(made);
}

const std::map<std::string, State>& State::children() const {
  while (!later_.empty()) make(later_.begin()->first);
  return children_;
}

State& State::child(const std::string& name) {
  make(name);
  State& found = children_[name];
  found.path_ = path_.empty() ? name : path_ + "/" + name;
  return found;
}

const State& State::child(const std::string& name) const {
  make(name);
  const auto found = children_.find(name);
  if (found == children_.end()) fail(name, "it is missing");
  return found->second;
}

const State* State::find(const std::string& path) const {
  const State* found = this;
  for (std::size_t begin = 0; begin < path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string name = path.substr(begin, end - begin);
    if (!found->hasChild(name)) return nullptr;
    found = &found->child(name);
    begin = end + 1;
  }
  return found;
}

void State::requireVersion(std::uint32_t version) const {
  const auto written = get<std::uint32_t>("version");
  if (written != version) {
    fail("version",
         "it is " + std::to_string(written) + "; this program reads version " + std::to_string(version));
  }
}

void State::setArray(const std::string& name, StateArray array) {
  const std::size_t size = stateTypeSize(array.type);
  const std::uint64_t numbers = array.bytes.size() / size;
  bool fits = array.bytes.size() % size == 0;
  if (rows_ && (array.shape.empty() || array.shape[0] != *rows_)) fits = false;
  for (std::size_t i = 1; rows_ && i < array.shape.size(); ++i) fits = fits && array.shape[i] > 0;
  if (array.ends.empty()) {
    fits = fits && countOf(array.shape) == numbers;
  } else {
    fits =
        fits && !array.shape.empty() && array.ends.size() == array.shape[0] && array.ends.back() == numbers;
    for (std::size_t i = 1; i < array.ends.size(); ++i) fits = fits && array.ends[i - 1] <= array.ends[i];
  }
  if (!fits) {
    fail(name,
         std::to_string(array.bytes.size()) + " bytes do not make " + describe(array.type, array.shape));
  }
  children_.erase(name);
  later_.erase(name);
  arrays_[name] = std::move(array);
}

const StateArray& State::array(const std::string& name) const {
  const auto found = arrays_.find(name);
  if (found == arrays_.end()) fail(name, "it is missing");
  return found->second;
}

const StateArray& State::arrayOf(const std::string& name, StateType type, const StateShape& element,
                                 std::size_t leading) const {
  const StateArray& found = array(name);
  const bool rank = found.shape.size() == element.size() + leading;
  if (found.type != type || !rank || !found.ends.empty() ||
      !std::equal(element.begin(), element.end(),
                  found.shape.begin() + static_cast<std::ptrdiff_t>(leading))) {
    fail(name, "it is " + describe(found.type, found.shape) + ", not " + describe(type, element) +
                   (leading > 0 ? " after " + std::to_string(leading) + " sizes of any value" : ""));
  }
  return found;
}

std::vector<std::uint8_t> State::toBytes() const {
  std::vector<std::uint8_t> bytes;
  put(bytes, kMagic);
  append(*this, bytes);
  return bytes;
}

void State::append(const State& state, std::vector<std::uint8_t>& bytes) {
  put(bytes, static_cast<std::uint8_t>(state.rows_ ? 1 : 0));
  if (state.rows_) put(bytes, *state.rows_);
  put(bytes, static_cast<std::uint64_t>(state.arrays_.size()));
  for (const auto& [name, array] : state.arrays_) {
    putText(bytes, name);
    put(bytes, array.type);
    putNumbers(bytes, array.shape);
    putNumbers(bytes, array.ends);
    putBlock(bytes, array.bytes.data(), array.bytes.size());
  }
  put(bytes, static_cast<std::uint64_t>(state.children().size()));
  for (const auto& [name, inner] : state.children()) {
    putText(bytes, name);
    append(inner, bytes);
  }
}

State State::fromBytes(const std::vector<std::uint8_t>& bytes) {
  std::size_t position = 0;
  if (Reader(bytes, position).take<std::uint64_t>() != kMagic) {
    throw std::runtime_error("state: these are not the bytes of a state");
  }
  State state;
  takeInto(bytes, position, state, 0);
  if (position != bytes.size()) throw std::runtime_error("state: bytes are left over behind its end");
  return state;
}

void State::takeInto(const std::vector<std::uint8_t>& bytes, std::size_t& position, State& state, int depth) {
  if (depth > kDeepest) throw std::runtime_error("state: it is nested too deeply");
  Reader reader(bytes, position);
  if (reader.take<std::uint8_t>() != 0) state.rows_ = reader.take<std::uint64_t>();
  for (std::uint64_t i = reader.checkedCount(8); i > 0; --i) {
    const std::string name = reader.takeName();
    StateArray array;
    array.type = reader.take<StateType>();
    array.shape = reader.takeNumbers();
    array.ends = reader.takeNumbers();
    array.bytes = reader.takeBlock();
    state.setArray(name, std::move(array));
  }
  if (state.rows_.value_or(0) > 0 && state.arrays_.empty()) {
    throw std::runtime_error("state: a table has rows and no columns");
  }
  for (std::uint64_t i = reader.checkedCount(8); i > 0; --i) {
    const std::string name = reader.takeName();
    takeInto(bytes, position, state.child(name), depth + 1);
  }
}

namespace state_detail {

void RowWriter::finish(State& table, std::uint64_t rows) {
  table.setRows(rows);
  for (auto& [name, array] : columns_) {
    array.shape.insert(array.shape.begin(), rows);
    table.setArray(name, std::move(array));
  }
}

const StateArray& RowReader::find(const std::string& name, StateType type, const StateShape& element,
                                  bool ragged) const {
  const StateArray& array = table_.array(name);
  StateShape expected = element;
  expected.insert(expected.begin(), *table_.rows());
  std::size_t numbers = 1;
  for (const std::uint64_t size : element) numbers *= static_cast<std::size_t>(size);
  bool fits = array.type == type && array.shape == expected && ragged == !array.ends.empty();
  for (const std::uint64_t end : array.ends) fits = fits && end % numbers == 0;
  if (!fits) {
    throw std::runtime_error("state " + table_.path() + "/" + name + ": it is " +
                             describe(array.type, array.shape) + ", not " + describe(type, expected) +
                             (ragged ? " of entries of different lengths" : ""));
  }
  return array;
}

}  // namespace state_detail
}  // namespace ratslam
