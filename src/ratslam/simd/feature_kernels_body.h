/// The feature kernels, see level_body.h.

constexpr int kLanes = RATSLAM_REGISTER_BYTES;
static_assert(kLanes <= kLeastRow, "rows may be shorter than a register");

typedef std::uint8_t Bytes __attribute__((vector_size(kLanes)));
typedef std::uint8_t LooseBytes __attribute__((vector_size(kLanes), aligned(1), may_alias));

inline Bytes load(const std::uint8_t* bytes) { return *reinterpret_cast<const LooseBytes*>(bytes); }
inline void store(std::uint8_t* bytes, Bytes value) { *reinterpret_cast<LooseBytes*>(bytes) = value; }

struct Larger {
  static Bytes of(Bytes a, Bytes b) { return a > b ? a : b; }
};
struct Smaller {
  static Bytes of(Bytes a, Bytes b) { return a < b ? a : b; }
};
/// max(0, a - b)
inline Bytes excess(Bytes a, Bytes b) { return Larger::of(a, b) - b; }

inline bool anySet(Bytes value) {
  typedef std::uint64_t Words __attribute__((vector_size(kLanes), may_alias));
  const Words words = reinterpret_cast<const Words&>(value);
  std::uint64_t all = 0;
  for (int i = 0; i < kLanes / 8; ++i) all |= words[i];
  return all != 0;
}

/// Calls operation(x) for vectors that cover `count` elements. The last one may overlap the one before.
template <class Operation>
inline void eachVector(int count, Operation operation) {
  int x = 0;
  for (; x + kLanes <= count; x += kLanes) operation(x);
  if (x < count) operation(count - kLanes);
}

/// Over the sixteen arcs of nine pixels, the extreme (Most) of the value that all pixels of an arc reach (Least). Two
/// neighbouring arcs share eight pixels, so each run of eight that begins at an even pixel is used for two arcs.
template <class Least, class Most>
inline Bytes bestArc(const Bytes (&circle)[16]) {
  Bytes two[8];
  Bytes four[8];
  for (int i = 0; i < 8; ++i) two[i] = Least::of(circle[2 * i], circle[2 * i + 1]);
  for (int i = 0; i < 8; ++i) four[i] = Least::of(two[i], two[(i + 1) % 8]);
  Bytes best{};
  for (int i = 0; i < 8; ++i) {
    const Bytes ends = Most::of(circle[(2 * i + 15) % 16], circle[(2 * i + 8) % 16]);
    const Bytes arc = Least::of(Least::of(four[i], four[(i + 2) % 8]), ends);
    best = i == 0 ? arc : Most::of(best, arc);
  }
  return best;
}

void cornerScores(const std::uint8_t* row, std::ptrdiff_t stride, int count, int threshold,
                  std::uint8_t* scores) {
  // The circle, clockwise from the top.
  constexpr int kX[16] = {0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
  constexpr int kY[16] = {-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
  std::ptrdiff_t offsets[16];
  for (int i = 0; i < 16; ++i) offsets[i] = kY[i] * stride + kX[i];
  const Bytes least = Bytes{} + static_cast<std::uint8_t>(threshold);

  eachVector(count, [&](int x) RATSLAM_LAMBDA {
    const std::uint8_t* at = row + x;
    const Bytes centre = load(at);
    // Nine consecutive pixels contain two neighbours of the four compass points. This test rejects flat regions quickly.
    const Bytes top = load(at + offsets[0]);
    const Bytes right = load(at + offsets[4]);
    const Bytes bottom = load(at + offsets[8]);
    const Bytes left = load(at + offsets[12]);
    const Bytes high = Smaller::of(Larger::of(top, bottom), Larger::of(left, right));
    const Bytes low = Larger::of(Smaller::of(top, bottom), Smaller::of(left, right));
    const Bytes possible = Larger::of(excess(high, centre), excess(centre, low));
    if (!anySet(excess(possible, least))) {
      store(scores + x, Bytes{});
      return;
    }
    Bytes circle[16];
    for (int i = 0; i < 16; ++i) circle[i] = load(at + offsets[i]);
    const Bytes bright = bestArc<Smaller, Larger>(circle);
    const Bytes dark = bestArc<Larger, Smaller>(circle);
    const Bytes contrast = Larger::of(excess(bright, centre), excess(centre, dark));
    store(scores + x, contrast > least ? contrast : Bytes{});
  });
}

void localMaxima(const std::uint8_t* const scores[3], int count, std::uint8_t* maxima) {
  eachVector(count, [&](int x) RATSLAM_LAMBDA {
    const Bytes here = load(scores[1] + x);
    if (!anySet(here)) {
      store(maxima + x, Bytes{});
      return;
    }
    Bytes around = Larger::of(load(scores[1] + x - 1), load(scores[1] + x + 1));
    for (int row = 0; row < 3; row += 2) {
      for (int dx = -1; dx <= 1; ++dx) around = Larger::of(around, load(scores[row] + x + dx));
    }
    store(maxima + x, here > around ? here : Bytes{});
  });
}

// Gaussian of 2 px deviation over seven pixels, in 256ths: 18 34 49 54 49 34 18.
inline std::uint8_t smoothed(int a, int b, int c, int d, int e, int f, int g) {
  const auto sum = static_cast<std::uint16_t>(18 * (a + g) + 34 * (b + f) + 49 * (c + e) + 54 * d + 128);
  return static_cast<std::uint8_t>(sum >> 8);
}

void smoothColumns(const std::uint8_t* const rows[7], int count, std::uint8_t* out) {
  const std::uint8_t* a = rows[0];
  const std::uint8_t* b = rows[1];
  const std::uint8_t* c = rows[2];
  const std::uint8_t* d = rows[3];
  const std::uint8_t* e = rows[4];
  const std::uint8_t* f = rows[5];
  const std::uint8_t* g = rows[6];
  for (int x = 0; x < count; ++x) out[x] = smoothed(a[x], b[x], c[x], d[x], e[x], f[x], g[x]);
}

void smoothRow(const std::uint8_t* row, int count, std::uint8_t* out) {
  for (int x = 0; x < count; ++x) {
    out[x] = smoothed(row[x - 3], row[x - 2], row[x - 1], row[x], row[x + 1], row[x + 2], row[x + 3]);
  }
}

/// Mask of the bytes of a row of 32 px around a corner that lie in the disc: all bits set or none.
struct DiscMask {
  std::uint8_t row[kDiscRadius + 1][32];
};

constexpr DiscMask makeDiscMask() {
  DiscMask mask{};
  for (int v = 0; v <= kDiscRadius; ++v) {
    for (int u = -kDiscRadius; u <= kDiscRadius; ++u) {
      mask.row[v][u + kDiscRadius] = u * u + v * v <= kDiscRadius * kDiscRadius ? 255 : 0;
    }
  }
  return mask;
}

constexpr DiscMask kDisc = makeDiscMask();

DiscMoments discMoments(const std::uint8_t* centre, std::ptrdiff_t stride) {
  // Sums by column. Rows above and below are added in pairs, so that 16 bits are enough.
  std::int16_t column[32];
  std::int16_t moment[32];
  for (int u = 0; u < 32; ++u) {
    column[u] = static_cast<std::int16_t>(centre[u - kDiscRadius] & kDisc.row[0][u]);
    moment[u] = 0;
  }
  for (int v = 1; v <= kDiscRadius; ++v) {
    const std::uint8_t* below = centre + v * stride - kDiscRadius;
    const std::uint8_t* above = centre - v * stride - kDiscRadius;
    for (int u = 0; u < 32; ++u) {
      const auto low = static_cast<std::int16_t>(below[u] & kDisc.row[v][u]);
      const auto high = static_cast<std::int16_t>(above[u] & kDisc.row[v][u]);
      column[u] = static_cast<std::int16_t>(column[u] + low + high);
      moment[u] = static_cast<std::int16_t>(moment[u] + v * (low - high));
    }
  }
  DiscMoments moments;
  for (int u = 0; u < 32; ++u) {
    moments.x += (u - kDiscRadius) * column[u];
    moments.y += moment[u];
  }
  return moments;
}

void describe(const std::uint8_t* centre, std::ptrdiff_t stride, const BriefPattern& pattern, int cosine,
              int sine, std::uint8_t* out) {
  constexpr int kHalf = 1 << 13;
  const int step = static_cast<int>(stride);
  std::int32_t offsets[2 * kBriefTests];
  for (int i = 0; i < 2 * kBriefTests; ++i) {
    const int x = (pattern.x[i] * cosine - pattern.y[i] * sine + kHalf) >> 14;
    const int y = (pattern.x[i] * sine + pattern.y[i] * cosine + kHalf) >> 14;
    offsets[i] = y * step + x;
  }
  for (int byte = 0; byte < kBriefTests / 8; ++byte) {
    unsigned bits = 0;
    for (int bit = 0; bit < 8; ++bit) {
      const int test = 8 * byte + bit;
      bits |= static_cast<unsigned>(centre[offsets[test]] < centre[offsets[kBriefTests + test]]) << bit;
    }
    out[byte] = static_cast<std::uint8_t>(bits);
  }
}

inline int countBits(std::uint64_t word) {
#if RATSLAM_REGISTER_BYTES > 16 || !defined(__x86_64__)
  return __builtin_popcountll(word);
#else
  // Without an instruction for it, sum the bits in larger and larger fields.
  word -= (word >> 1) & 0x5555555555555555U;
  word = (word & 0x3333333333333333U) + ((word >> 2) & 0x3333333333333333U);
  word = (word + (word >> 4)) & 0x0f0f0f0f0f0f0f0fU;
  return static_cast<int>((word * 0x0101010101010101U) >> 56);
#endif
}

inline int hammingDistance(const std::uint8_t* a, const std::uint8_t* b) {
  int distance = 0;
  for (int word = 0; word < 4; ++word) {
    std::uint64_t one = 0;
    std::uint64_t other = 0;
    std::memcpy(&one, a + 8 * word, 8);
    std::memcpy(&other, b + 8 * word, 8);
    distance += countBits(one ^ other);
  }
  return distance;
}

void hammingDistances(const std::uint8_t* one, const std::uint8_t* others, std::size_t count,
                      int* distances) {
  for (std::size_t i = 0; i < count; ++i) distances[i] = hammingDistance(one, others + 32 * i);
}

constexpr FeatureKernels kFeatureKernels{cornerScores, localMaxima, smoothColumns,   smoothRow,
                                         discMoments,  describe,    hammingDistance, hammingDistances};
