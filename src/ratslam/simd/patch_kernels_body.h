/// The patch kernels, see level_body.h. If registers are narrower than a row, it is processed in parts.

typedef float Row __attribute__((vector_size(4 * kPatchColumns)));
typedef float LooseRow __attribute__((vector_size(4 * kPatchColumns), aligned(4), may_alias));
typedef std::int32_t Ints __attribute__((vector_size(4 * kPatchColumns)));

// Vectors are not passed by value, because their calling convention depends on the instruction set. Rows in memory are not
// passed by reference, because clang then assumes that they are aligned.
#define RATSLAM_ROW(values) (*reinterpret_cast<const LooseRow*>(values))
inline void storeRow(const Row& row, float* values) { *reinterpret_cast<LooseRow*>(values) = row; }
inline void loadGreys(const std::uint8_t* bytes, Row& row) {
#if RATSLAM_REGISTER_BYTES == 64
  constexpr __mmask16 kAll = 0xffff;  // without a mask GCC 12 warns about its own header
  const __m128i greys = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
  _mm512_storeu_ps(&row, _mm512_maskz_cvtepi32_ps(kAll, _mm512_maskz_cvtepu8_epi32(kAll, greys)));
#elif RATSLAM_REGISTER_BYTES == 32
  const __m128i greys = _mm_loadu_si128(reinterpret_cast<const __m128i*>(bytes));
  auto* out = reinterpret_cast<float*>(&row);
  _mm256_storeu_ps(out, _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(greys)));
  _mm256_storeu_ps(out + 8, _mm256_cvtepi32_ps(_mm256_cvtepu8_epi32(_mm_srli_si128(greys, 8))));
#else
  for (int i = 0; i < kPatchColumns; ++i) row[i] = static_cast<float>(bytes[i]);
#endif
}
inline float sumOf(const Row& row) {
  float parts[8];
  for (int i = 0; i < 8; ++i) parts[i] = row[i] + row[i + 8];
  return ((parts[0] + parts[4]) + (parts[2] + parts[6])) + ((parts[1] + parts[5]) + (parts[3] + parts[7]));
}

/// Column and row of each sample of the rim.
struct RimPlaces {
  float u[kRimStorage];
  float v[kRimStorage];
};

constexpr RimPlaces makeRimPlaces() {
  RimPlaces places{};
  for (int i = 0; i < kRimArea; ++i) {
    places.u[i] = static_cast<float>(i % kRimColumns);
    const int row = i / kRimColumns;
    places.v[i] = static_cast<float>(row);
  }
  return places;
}

constexpr RimPlaces kRimPlaces = makeRimPlaces();

void sampleRim(const std::uint8_t* image, std::ptrdiff_t stride, const float* origin, const float* step,
               float* rim) {
  const auto row_step = static_cast<std::int32_t>(stride);
  for (int i = 0; i < kRimStorage; i += kPatchColumns) {
    const Row x =
        origin[0] + step[0] * RATSLAM_ROW(kRimPlaces.u + i) + step[1] * RATSLAM_ROW(kRimPlaces.v + i);
    const Row y =
        origin[1] + step[2] * RATSLAM_ROW(kRimPlaces.u + i) + step[3] * RATSLAM_ROW(kRimPlaces.v + i);
    const Ints column = __builtin_convertvector(x, Ints);
    const Ints line = __builtin_convertvector(y, Ints);
    const Row fx = x - __builtin_convertvector(column, Row);
    const Row fy = y - __builtin_convertvector(line, Row);
    const Ints offset = line * row_step + column;
    Ints upper;
    Ints lower;
    for (int k = 0; k < kPatchColumns; ++k) {
      std::uint16_t pair = 0;
      std::memcpy(&pair, image + offset[k], 2);
      upper[k] = pair;
      std::memcpy(&pair, image + offset[k] + stride, 2);
      lower[k] = pair;
    }
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    upper = (upper >> 8) | ((upper & 255) << 8);
    lower = (lower >> 8) | ((lower & 255) << 8);
#endif
    const Row above = (1.0F - fx) * __builtin_convertvector(upper & 255, Row) +
                      fx * __builtin_convertvector(upper >> 8, Row);
    const Row below = (1.0F - fx) * __builtin_convertvector(lower & 255, Row) +
                      fx * __builtin_convertvector(lower >> 8, Row);
    storeRow((1.0F - fy) * above + fy * below, rim + i);
  }
}

TemplateSums fillTemplate(const float* rim, PatchTemplate& patch) {
  Row value{};
  Row along_x{};
  Row along_y{};
  for (int v = 0; v < kPatchRows; ++v) {
    const float* at = rim + (v + 1) * kRimColumns + 1;
    const Row here = RATSLAM_ROW(at);
    const Row right = 0.5F * (RATSLAM_ROW(at + 1) - RATSLAM_ROW(at - 1));
    const Row down = 0.5F * (RATSLAM_ROW(at + kRimColumns) - RATSLAM_ROW(at - kRimColumns));
    storeRow(here, patch.value + v * kPatchColumns);
    storeRow(right, patch.gradient_x + v * kPatchColumns);
    storeRow(down, patch.gradient_y + v * kPatchColumns);
    value += here;
    along_x += right;
    along_y += down;
  }
  constexpr float kShare = 1.0F / static_cast<float>(kPatchArea);
  patch.mean = kShare * sumOf(value);
  const float mean_x = kShare * sumOf(along_x);
  const float mean_y = kShare * sumOf(along_y);
  Row vv{};
  Row vx{};
  Row vy{};
  Row xx{};
  Row xy{};
  Row yy{};
  for (int i = 0; i < kPatchArea; i += kPatchColumns) {
    const Row here = RATSLAM_ROW(patch.value + i) - patch.mean;
    const Row right = RATSLAM_ROW(patch.gradient_x + i) - mean_x;
    const Row down = RATSLAM_ROW(patch.gradient_y + i) - mean_y;
    storeRow(here, patch.value + i);
    storeRow(right, patch.gradient_x + i);
    storeRow(down, patch.gradient_y + i);
    vv += here * here;
    vx += here * right;
    vy += here * down;
    xx += right * right;
    xy += right * down;
    yy += down * down;
  }
  return {sumOf(vv), sumOf(vx), sumOf(vy), sumOf(xx), sumOf(xy), sumOf(yy)};
}

PatchSums compare(const std::uint8_t* corner, std::ptrdiff_t stride, float fx, float fy,
                  const PatchTemplate& patch) {
  Row sum{};
  Row square{};
  Row product{};
  Row along_x{};
  Row along_y{};
  Row upper;
  Row left;
  Row right;
  loadGreys(corner, left);
  loadGreys(corner + 1, right);
  upper = (1.0F - fx) * left + fx * right;
  for (int v = 0; v < kPatchRows; ++v) {
    const std::uint8_t* at = corner + (v + 1) * stride;
    loadGreys(at, left);
    loadGreys(at + 1, right);
    const Row lower = (1.0F - fx) * left + fx * right;
    const Row value = (1.0F - fy) * upper + fy * lower - patch.mean;
    upper = lower;
    sum += value;
    square += value * value;
    product += value * RATSLAM_ROW(patch.value + v * kPatchColumns);
    along_x += value * RATSLAM_ROW(patch.gradient_x + v * kPatchColumns);
    along_y += value * RATSLAM_ROW(patch.gradient_y + v * kPatchColumns);
  }
  return {sumOf(sum), sumOf(square), sumOf(product), sumOf(along_x), sumOf(along_y)};
}

constexpr PatchKernels kPatchKernels{sampleRim, fillTemplate, compare};

#undef RATSLAM_ROW
