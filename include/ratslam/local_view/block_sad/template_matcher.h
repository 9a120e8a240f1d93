/// Search of the learned template most similar to a view (docs/model.md section 1, step 5). It is exact, and much
/// faster than comparing every value of every template.
///
///   1. Mean gate: exclude templates whose mean differs too much from the view's.
///   2. Coarse bound: the SAD of the 8-bit means of about 30 blocks is a lower bound for each template's error
///      (block_grid.h).
///   3. Fine bounds: for the remaining templates the SAD of all values in 8 bits bounds the error from both sides.
///      The template with the smallest coarse bound is first, so that it excludes most others.
///   4. Exact error: the few templates whose bounds overlap those of the best are compared in double. Their values are
///      computed again from packed sums (packed_template.h), row by row and column by column.
///
/// An 8-bit SAD differs from 255 times the true sum by at most the rounding of the values of view and template, which
/// is stored for each. Hence winner, error, ties and decision are those of an exhaustive search in double.
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
  /// @throws std::invalid_argument as LocalViewParams::validate does, and if this processor lacks the level.
  explicit TemplateMatcher(const LocalViewParams& params, SimdLevel level = bestSimdLevel());

  /// Stores a template, at a cost that does not depend on their number. Its id is the number of templates before it.
  /// @throws std::invalid_argument for a template of another size than the parameters'.
  std::uint32_t add(const ViewTemplate& learned);

  /// The template with the smallest error, of equals the lowest id, then the lowest shift; none if the mean gate
  /// leaves no candidate. @throws std::invalid_argument as add does.
  std::optional<TemplateMatch> findBest(const ViewTemplate& view);

  /// The error of template `id` at the shift where it is smallest, without the mean gate. @throws std::out_of_range.
  TemplateMatch compareWith(const ViewTemplate& view, std::uint32_t id);

  /// For every template, minus the smallest error over all shifts, computed from 8-bit values, without the mean gate.
  void likeness(const ViewTemplate& view, std::vector<float>& values);

  std::size_t size() const { return packed_.size(); }

  /// Values of template `id` as they were added, to the last bit, row by row. @throws std::out_of_range.
  std::vector<double> values(std::uint32_t id) const;

  /// Block sums of template `id`, from which its values are computed. Sums that give value 1 are clamped to the least
  /// such sum. @throws std::out_of_range.
  BlockSums blocks(std::uint32_t id) const;
  /// The scale with which its values are computed from these. @throws std::out_of_range.
  double scale(std::uint32_t id) const { return packed_.at(id).scale(); }

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
    std::uint32_t rounding = 0;  // largest difference from the true sum
    std::uint32_t id = 0;
  };

  struct MeanRange {
    double low = 0.0;
    double high = 0.0;
  };

  /// A template in a State.
  struct Row {
    double mean = 0.0;
    std::vector<std::uint8_t> values;  // in 8 bits, row by row
    PackedTemplate::Record exact;      // for the exact values

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
  std::vector<double> means_;            // of whole groups; infinite for missing templates
  std::vector<MeanRange> mean_ranges_;   // of the templates of each group
  std::vector<std::uint32_t> rounding_;  // sum of the changes by rounding to 8 bits [levels]
  std::uint32_t largest_rounding_ = 0;
  std::vector<PackedTemplate> packed_;
  // Buffers of a search.
  std::vector<std::uint32_t> coarse_sads_;
  std::vector<Candidate> candidates_;
  std::vector<std::uint8_t> view_bytes_;
  std::vector<std::uint32_t> shift_sads_;
};

}  // namespace ratslam
