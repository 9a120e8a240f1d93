/// The row kernels, see level_body.h.

constexpr int kLanes = RATSLAM_REGISTER_BYTES / 8;
constexpr int kParts = kRowQuantum / kLanes;

typedef double Vec __attribute__((vector_size(kLanes * sizeof(double))));
typedef double LooseVec __attribute__((vector_size(kLanes * sizeof(double)), aligned(8), may_alias));
typedef long long Mask __attribute__((vector_size(kLanes * sizeof(double))));
typedef long long LooseMask __attribute__((vector_size(kLanes * sizeof(double)), aligned(8), may_alias));

inline Vec load(const double* cells) { return *reinterpret_cast<const LooseVec*>(cells); }
inline void store(double* cells, Vec value) { *reinterpret_cast<LooseVec*>(cells) = value; }
inline Vec larger(Vec a, Vec b) { return a > b ? a : b; }

inline double largestLane(Vec value) {
  double largest = value[0];
  for (int lane = 1; lane < kLanes; ++lane) largest = value[lane] > largest ? value[lane] : largest;
  return largest;
}

template <class Operation>
inline void eachSegment(RowSet<const double> in, RowSet<double> out, int rows, const RowSegment* segments,
                        int n_segments, Operation operation) {
  for (int s = 0; s < n_segments; ++s) {
    const RowSegment segment = segments[s];
    for (int r = 0; r < rows; ++r)
      operation(in.data + in.offsets[r] + segment.from, out.data + out.offsets[r] + segment.to,
                segment.count);
  }
}

/// Copies fewer than 2 * kCount cells by two overlapping copies of kCount cells; for shorter rows with half of kCount.
template <int kCount>
inline void copyShort(const double* from, double* to, int count) {
  // Without a vector type, because GCC 9 loses the alignment of one whose size depends on a template parameter.
  if (count >= kCount) {
    double first[kCount];
    double last[kCount];
    __builtin_memcpy(first, from, sizeof(first));
    __builtin_memcpy(last, from + count - kCount, sizeof(last));
    __builtin_memcpy(to, first, sizeof(first));
    __builtin_memcpy(to + count - kCount, last, sizeof(last));
  } else if constexpr (kCount > 2) {
    copyShort<kCount / 2>(from, to, count);
  } else if (count == 1) {
    *to = *from;
  }
}

void copyRows(RowSet<const double> in, RowSet<double> out, int rows, const RowSegment* segments,
              int n_segments) {
  eachSegment(in, out, rows, segments, n_segments,
              [](const double* from, double* to, int count) RATSLAM_LAMBDA {
                int x = 0;
                for (; x + 2 * kLanes < count; x += kLanes) store(to + x, load(from + x));
                copyShort<kLanes>(from + x, to + x, count - x);
              });
}

template <bool kAdd>
void blend(RowSet<const double> in, std::ptrdiff_t other, const double* weights, RowSet<double> out, int rows,
           const RowSegment* segments, int n_segments) {
  const double here = weights[0];
  const double there = weights[1];
  eachSegment(in, out, rows, segments, n_segments,
              [=](const double* from, double* to, int count) RATSLAM_LAMBDA {
                int x = 0;
                for (; x + kLanes <= count; x += kLanes) {
                  const Vec blended = load(from + x) * here + load(from + x + other) * there;
                  store(to + x, kAdd ? load(to + x) + blended : blended);
                }
                for (; x < count; ++x)
                  to[x] = (kAdd ? to[x] : 0.0) + (from[x] * here + from[x + other] * there);
              });
}

/// If `kRadius` is not 0, the radius is a constant and the compiler can unroll the loop.
template <int kRadius>
void convolveRows(const double* const* taps, std::ptrdiff_t in_stride, double* out, std::ptrdiff_t out_stride,
                  int rows, std::ptrdiff_t width, const double* weights, int any_radius) {
  const int radius = kRadius > 0 ? kRadius : any_radius;
  for (int r = 0; r < rows; ++r, out += out_stride) {
    const std::ptrdiff_t row = r * in_stride;
    for (std::ptrdiff_t x = 0; x < width; x += kLanes) {
      const std::ptrdiff_t at = row + x;
      Vec sum = load(taps[radius] + at) * weights[0];
      for (int t = 1; t <= radius; ++t)
        sum += (load(taps[radius - t] + at) + load(taps[radius + t] + at)) * weights[t];
      store(out + x, sum);
    }
  }
}

void convolve(const double* const* taps, std::ptrdiff_t in_stride, double* out, std::ptrdiff_t out_stride,
              int rows, std::ptrdiff_t width, const double* weights, int radius) {
  if (radius == 3) {
    const double* const fixed[] = {taps[0], taps[1], taps[2], taps[3], taps[4], taps[5], taps[6]};
    const double factors[] = {weights[0], weights[1], weights[2], weights[3]};
    convolveRows<3>(fixed, in_stride, out, out_stride, rows, width, factors, radius);
  } else if (radius == 2) {
    const double* const fixed[] = {taps[0], taps[1], taps[2], taps[3], taps[4]};
    const double factors[] = {weights[0], weights[1], weights[2]};
    convolveRows<2>(fixed, in_stride, out, out_stride, rows, width, factors, radius);
  } else {
    convolveRows<0>(taps, in_stride, out, out_stride, rows, width, weights, radius);
  }
}

void correlate(const double* in, std::ptrdiff_t tap, double* out, std::ptrdiff_t width, const double* weights,
               int taps) {
  if (taps == 2) {
    const double here = weights[0];
    const double there = weights[1];
    for (std::ptrdiff_t x = 0; x < width; x += kLanes)
      store(out + x, load(in + x) * here + load(in + x + tap) * there);
    return;
  }
  for (std::ptrdiff_t x = 0; x < width; x += kLanes) {
    Vec sum = load(in + x) * weights[0];
    for (int t = 1; t < taps; ++t) sum += load(in + x + t * tap) * weights[t];
    store(out + x, sum);
  }
}

double findMaxima(const double* in, int rows, int width, Maxima maxima) {
  Vec of_layer{};
  for (int j = 0; j < rows; ++j) {
    Vec of_row = load(maxima.rows + j * kRowQuantum);
    for (int x = 0; x < width; x += kLanes) {
      const Vec value = load(in + x);
      of_row = larger(value, of_row);
      of_layer = larger(value, of_layer);
      store(maxima.columns + x, larger(value, load(maxima.columns + x)));
    }
    store(maxima.rows + j * kRowQuantum, of_row);
    in += width;
  }
  return largestLane(of_layer);
}

double inhibit(const double* excited, std::ptrdiff_t excited_stride, double* cells, int rows, int width,
               double global, const long long* keep, double* sums, Maxima maxima) {
  Vec partial[kParts];
  for (int p = 0; p < kParts; ++p) partial[p] = load(sums + p * kLanes);
  Vec of_layer{};
  for (int j = 0; j < rows; ++j) {
    Vec of_row = load(maxima.rows + j * kRowQuantum);
    for (int x = 0; x < width; x += kRowQuantum) {
      for (int p = 0; p < kParts; ++p) {
        const int at = x + p * kLanes;
        const Vec left = load(excited + at) - load(cells + at) - global;
        const Mask positive = left > 0.0;
        const Vec value = (positive & *reinterpret_cast<const LooseMask*>(keep + at)) ? left : Vec{};
        store(cells + at, value);
        partial[p] += value;
        of_row = larger(value, of_row);
        of_layer = larger(value, of_layer);
        store(maxima.columns + at, larger(value, load(maxima.columns + at)));
      }
    }
    store(maxima.rows + j * kRowQuantum, of_row);
    excited += excited_stride;
    cells += width;
  }
  for (int p = 0; p < kParts; ++p) store(sums + p * kLanes, partial[p]);
  return largestLane(of_layer);
}

double maximum(const double* in, std::ptrdiff_t count) {
  double largest = in[0];
  std::ptrdiff_t x = 0;
  if (count >= kLanes) {
    Vec lanes = load(in);
    for (; x + kLanes <= count; x += kLanes) lanes = larger(load(in + x), lanes);
    largest = largestLane(lanes);
  }
  for (; x < count; ++x) largest = in[x] > largest ? in[x] : largest;
  return largest;
}

constexpr RowKernels kKernels{copyRows,  blend<false>, blend<true>, convolve,
                              correlate, findMaxima,   inhibit,     maximum};
