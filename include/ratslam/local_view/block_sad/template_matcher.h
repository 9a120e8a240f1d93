/// Search of the learned template most like a view (docs/model.md section 1, step 5): exact, and much faster than
/// comparing every value of every template.
///
///   1. Mean gate. Templates whose mean differs too much from the view's are no candidates.
///   2. Coarse bound. The SAD of the means of some 30 blocks, in 8 bits, bounds each template's error from
///      below (block_grid.h).
///   3. Fine bounds. For what that does not exclude, the SAD of all values in 8 bits bounds the error from
///      both sides. The template of the smallest coarse bound goes first, so that it excludes most others.
///   4. Exact error. The few templates whose bounds overlap the best's are compared in double, their
///      values computed again from packed sums (packed_template.h), row by row and column by column.
///
/// An 8-bit SAD differs from 255 times the true sum by no more than rounding moved the values of view and
/// template, which is kept for each. Hence winner, error, ties and decision are those of an exhaustive search
/// in double.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "ratslam/local_view/block_sad/packed_template.h"
#include "ratslam/local_view/block_sad/sad_index.h"
#include "ratslam/local_view/block_sad/view_template.h"
#include "ratslam/local_view/local_view_params.h"
#include "ratslam/simd/simd_level.h"

namespace ratslam {

class State;

/// The best candidate of a search.
struct TemplateMatch {
  std::uint32_t id = 0;
  int shift = 0;       ///< [template columns]
  double error = 0.0;  ///< mean absolute difference at that shift
};

class TemplateMatcher {
 public:
  /// @throws std::invalid_argument as LocalViewParams::validate does, and where this processor lacks the
  /// level.
  explicit TemplateMatcher(const LocalViewParams& params, SimdLevel level = bestSimdLevel());

  /// Stores a template, at a cost that does not depend on how many there are. Its id is the number of
  /// templates before it. @throws std::invalid_argument for a template of another size than the parameters'.
  std::uint32_t add(const ViewTemplate& learned);

  /// The template of the smallest error, of equals the lowest id, then the lowest shift; none where the mean
  /// gate leaves no candidate. @throws std::invalid_argument as add does.
  std::optional<TemplateMatch> findBest(const ViewTemplate& view);

  /// The error of template `id`, at the shift where it is smallest; no gate is asked. @throws
  /// std::out_of_range.
  TemplateMatch compareWith(const ViewTemplate& view, std::uint32_t id);

  /// Of every template, minus the error at the shift where it is smallest, as values in 8 bits have it; no
  /// gate is asked.
  void likeness(const ViewTemplate& view, std::vector<float>& values);

  std::size_t size() const { return packed_.size(); }

  /// Values of template `id` as they were added, to the last bit, row by row. @throws std::out_of_range.
  std::vector<double> values(std::uint32_t id) const;

  /// Block sums of template `id`: what its values are computed from, sums that make a value of 1 cut to the least of them.
  /// @throws std::out_of_range.
  BlockSums blocks(std::uint32_t id) const;

  /// Values of template `id` in 8 bits, row by row. @throws std::out_of_range.
  std::vector<std::uint8_t> bytes(std::uint32_t id) const;

  /// A table of the templates.
  void save(State& state) const;
  /// @throws std::runtime_error naming what is missing or does not fit the parameters
  void load(const State& state);

  /// Memory held for the templates.
  std::size_t memoryBytes() const;

 private:
  struct Candidate {
    std::uint32_t sad = 0;       // of all values in 8 bits
    std::uint32_t rounding = 0;  // how much the true one may differ
    std::uint32_t id = 0;
  };

  struct MeanRange {
    double low = 0.0;
    double high = 0.0;
  };

  /// A template as a State keeps it.
  struct Row {
    double mean = 0.0;
    std::vector<std::uint8_t> values;  // in 8 bits, row by row
    PackedTemplate::Record exact;      // what the values were before

    template <class Fields>
    void stateFields(Fields&& fields) {
      fields("mean", mean);
      fields("values", values);
      fields("exact", exact);
    }
  };

  void checkSize(const ViewTemplate& view) const;
  void append(const std::vector<double>& values, double mean, PackedTemplate packed);
  std::optional<std::size_t> boundCoarsely(double view_mean);
  void collectCandidates(std::size_t most_likely, std::uint32_t view_rounding);
  void refine(const Candidate& candidate, const std::vector<double>& view,
              std::optional<TemplateMatch>& best);

  LocalViewParams params_;
  SimdLevel level_;
  std::size_t compared_values_;          // at each shift
  SadIndex coarse_;                      // means of blocks
  SadIndex fine_;                        // all values
  std::vector<double> means_;            // of whole groups: infinite where there is no template yet
  std::vector<MeanRange> mean_ranges_;   // of the templates of each group
  std::vector<std::uint32_t> rounding_;  // sum of what rounding to 8 bits moved the values, in levels
  std::uint32_t largest_rounding_ = 0;
  std::vector<PackedTemplate> packed_;
  // Buffers of a search.
  std::vector<std::uint32_t> coarse_sads_;
  std::vector<Candidate> candidates_;
  std::vector<std::uint8_t> view_bytes_;
  std::vector<std::uint32_t> shift_sads_;
};

}  // namespace ratslam
