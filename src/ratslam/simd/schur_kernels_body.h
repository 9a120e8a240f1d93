/// The Schur kernels, for whichever instruction set the including source has chosen. It includes this file
/// inside an unnamed namespace of its own target: nothing here may be shared between targets by the linker.

typedef double Column __attribute__((vector_size(8 * kSchurRows), aligned(8), may_alias));

inline const Column& columnAt(const double* rows) { return *reinterpret_cast<const Column*>(rows); }
inline Column& columnAt(double* rows) { return *reinterpret_cast<Column*>(rows); }

void eliminatePoint(const FreeView* views, int count, const PointEquations& point, int poses,
                    PoseEquations* equations) {
  for (const FreeView* a = views; a != views + count; ++a) {
    Column product[3];
    for (int k = 0; k < 3; ++k) {
      product[k] =
          (columnAt(a->coupling[0]) * point.inverse[0][k] + columnAt(a->coupling[1]) * point.inverse[1][k]) +
          columnAt(a->coupling[2]) * point.inverse[2][k];
    }
    PoseEquations* row = equations + a->pose * poses;
    Column& gradient = columnAt(row[a->pose].gradient);
    gradient -=
        (product[0] * point.gradient[0] + product[1] * point.gradient[1]) + product[2] * point.gradient[2];
    for (const FreeView* b = views; b != views + count; ++b) {
      if (b->pose > a->pose) continue;
      double(*block)[kSchurRows] = row[b->pose].hessian;
      for (int j = 0; j < 6; ++j) {
        columnAt(block[j]) -= (product[0] * b->coupling[0][j] + product[1] * b->coupling[1][j]) +
                              product[2] * b->coupling[2][j];
      }
    }
  }
}

constexpr SchurKernels kSchurKernels{eliminatePoint};
