/// The row kernels, for whichever instruction set the including source has chosen. It defines
/// RATSLAM_SIMD_LANES (doubles in a register) and includes this file inside an unnamed namespace of its own
/// target, after all standard headers: nothing here may be shared between targets by the linker.

constexpr int kLanes = RATSLAM_SIMD_LANES;
constexpr int kParts = kRowQuantum / kLanes;

typedef double Vec __attribute__((vector_size(kLanes * sizeof(double)), aligned(8), may_alias));
typedef long long Mask __attribute__((vector_size(kLanes * sizeof(double)), aligned(8), may_alias));

inline Vec load(const double* cells) { return *reinterpret_cast<const Vec*>(cells); }
inline void store(double* cells, Vec value) { *reinterpret_cast<Vec*>(cells) = value; }
inline Vec larger(Vec a, Vec b) { return a > b ? a : b; }

inline double largestLane(Vec value) {
  double largest = value[0];
  for (int lane = 1; lane < kLanes; ++lane) largest = value[lane] > largest ? value[lane] : largest;
  return largest;
}

template <class Operation>
inline void eachSegment(RowSet<const double> in, RowSet<double> out, int rows, const RowSegment* segments,
                        int n_segments, Operation operation) {
  for (int r = 0; r < rows; ++r) {
    for (int s = 0; s < n_segments; ++s)
      operation(in.data + in.offsets[r] + segments[s].from, out.data + out.offsets[r] + segments[s].to,
                segments[s].count);
  }
}

void copyRows(RowSet<const double> in, RowSet<double> out, int rows, const RowSegment* segments,
              int n_segments) {
  eachSegment(in, out, rows, segments, n_segments, [](const double* from, double* to, int count) {
    if (count < kLanes) {
      for (int x = 0; x < count; ++x) to[x] = from[x];
      return;
    }
    for (int x = 0; x < count - kLanes; x += kLanes) store(to + x, load(from + x));
    store(to + count - kLanes,
          load(from + count - kLanes));  // may overlap the one before: it writes the same
  });
}

void addRows(RowSet<const double> in, RowSet<double> out, int rows, const RowSegment* segments,
             int n_segments) {
  eachSegment(in, out, rows, segments, n_segments, [](const double* from, double* to, int count) {
    int x = 0;
    for (; x + kLanes <= count; x += kLanes) store(to + x, load(to + x) + load(from + x));
    for (; x < count; ++x) to[x] += from[x];
  });
}

/// The radius is a constant where `kRadius` is not 0, which lets the compiler unroll.
template <int kRadius>
void convolveRows(const double* in, std::ptrdiff_t in_stride, std::ptrdiff_t tap, double* out,
                  std::ptrdiff_t out_stride, int rows, std::ptrdiff_t width, const double* weights,
                  int any_radius) {
  const int radius = kRadius > 0 ? kRadius : any_radius;
  for (int r = 0; r < rows; ++r, in += in_stride, out += out_stride) {
    for (std::ptrdiff_t x = 0; x < width; x += kLanes) {
      const double* centre = in + x + radius * tap;
      Vec sum = load(centre) * weights[0];
      for (int t = 1; t <= radius; ++t) sum += (load(centre - t * tap) + load(centre + t * tap)) * weights[t];
      store(out + x, sum);
    }
  }
}

void convolve(const double* in, std::ptrdiff_t in_stride, std::ptrdiff_t tap, double* out,
              std::ptrdiff_t out_stride, int rows, std::ptrdiff_t width, const double* weights, int radius) {
  if (radius == 3) {
    convolveRows<3>(in, in_stride, tap, out, out_stride, rows, width, weights, radius);
  } else if (radius == 2) {
    convolveRows<2>(in, in_stride, tap, out, out_stride, rows, width, weights, radius);
  } else {
    convolveRows<0>(in, in_stride, tap, out, out_stride, rows, width, weights, radius);
  }
}

void correlate(const double* in, std::ptrdiff_t tap, double* out, std::ptrdiff_t width, const double* weights,
               int taps) {
  if (taps == 2) {
    for (std::ptrdiff_t x = 0; x < width; x += kLanes)
      store(out + x, load(in + x) * weights[0] + load(in + x + tap) * weights[1]);
    return;
  }
  for (std::ptrdiff_t x = 0; x < width; x += kLanes) {
    Vec sum = load(in + x) * weights[0];
    for (int t = 1; t < taps; ++t) sum += load(in + x + t * tap) * weights[t];
    store(out + x, sum);
  }
}

/// Goes through a volume row by row and keeps the largest values of what `cell(layer, row, x)` returns.
template <class Row>
inline void eachRowWithMaxima(int layers, int rows, int width, AxisMaxima maxima, Row row) {
  for (int x = 0; x < width; ++x) maxima.columns[x] = 0.0;
  for (int j = 0; j < rows; ++j) maxima.rows[j] = 0.0;
  for (int k = 0; k < layers; ++k) {
    maxima.layers[k] = 0.0;
    for (int j = 0; j < rows; ++j) {
      const double largest = largestLane(row(k, j));
      if (largest > maxima.rows[j]) maxima.rows[j] = largest;
      if (largest > maxima.layers[k]) maxima.layers[k] = largest;
    }
  }
}

void findMaxima(VolumeView<const double> in, int layers, int rows, int width, AxisMaxima maxima) {
  eachRowWithMaxima(layers, rows, width, maxima, [&](int k, int j) {
    const double* cells = in.data + k * in.layer_stride + j * in.row_stride;
    Vec largest{};
    for (int x = 0; x < width; x += kLanes) {
      const Vec value = load(cells + x);
      largest = larger(value, largest);
      store(maxima.columns + x, larger(value, load(maxima.columns + x)));
    }
    return largest;
  });
}

void inhibit(VolumeView<const double> excited, VolumeView<double> cells, int layers, int rows, int width,
             double global, const long long* keep, double* sums, AxisMaxima maxima) {
  Vec partial[kParts];
  for (int p = 0; p < kParts; ++p) partial[p] = load(sums + p * kLanes);
  eachRowWithMaxima(layers, rows, width, maxima, [&](int k, int j) {
    const double* from = excited.data + k * excited.layer_stride + j * excited.row_stride;
    double* to = cells.data + k * cells.layer_stride + j * cells.row_stride;
    Vec largest{};
    for (int x = 0; x < width; x += kRowQuantum) {
      for (int p = 0; p < kParts; ++p) {
        const int at = x + p * kLanes;
        const Vec left = load(from + at) - load(to + at) - global;
        const Mask positive = left > 0.0;
        const Vec value = (positive & *reinterpret_cast<const Mask*>(keep + at)) ? left : Vec{};
        store(to + at, value);
        partial[p] += value;
        largest = larger(value, largest);
        store(maxima.columns + at, larger(value, load(maxima.columns + at)));
      }
    }
    return largest;
  });
  for (int p = 0; p < kParts; ++p) store(sums + p * kLanes, partial[p]);
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

constexpr RowKernels kKernels{copyRows, addRows, convolve, correlate, findMaxima, inhibit, maximum};
