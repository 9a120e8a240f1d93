/// The Schur kernels, see level_body.h.

typedef double Column __attribute__((vector_size(8 * kSchurRows)));
typedef double LooseColumn __attribute__((vector_size(8 * kSchurRows), aligned(8), may_alias));

// Columns in memory are not passed by reference, because clang then assumes that they are aligned.
#define RATSLAM_COLUMN(rows) (*reinterpret_cast<const LooseColumn*>(rows))
inline void subtract(const Column& change, double* rows) { *reinterpret_cast<LooseColumn*>(rows) -= change; }

void eliminatePoint(const FreeView* views, int count, const PointEquations& point, int poses,
                    PoseEquations* equations) {
  for (const FreeView* a = views; a != views + count; ++a) {
    Column product[3];
    for (int k = 0; k < 3; ++k) {
      product[k] = (RATSLAM_COLUMN(a->coupling[0]) * point.inverse[0][k] +
                    RATSLAM_COLUMN(a->coupling[1]) * point.inverse[1][k]) +
                   RATSLAM_COLUMN(a->coupling[2]) * point.inverse[2][k];
    }
    PoseEquations* row = equations + a->pose * poses;
    subtract(
        (product[0] * point.gradient[0] + product[1] * point.gradient[1]) + product[2] * point.gradient[2],
        row[a->pose].gradient);
    for (const FreeView* b = views; b != views + count; ++b) {
      if (b->pose > a->pose) continue;
      double(*block)[kSchurRows] = row[b->pose].hessian;
      for (int j = 0; j < 6; ++j) {
        subtract((product[0] * b->coupling[0][j] + product[1] * b->coupling[1][j]) +
                     product[2] * b->coupling[2][j],
                 block[j]);
      }
    }
  }
}

constexpr SchurKernels kSchurKernels{eliminatePoint};

#undef RATSLAM_COLUMN
