/// One seed gives the same town whatever compiler built it. Sums with random weights stand for the town: another order of
/// random draws changes them by far more than a texel or a corner that is rounded otherwise.
#include <gtest/gtest.h>

#include <cmath>

#include "town/hash.h"
#include "town_test_support.h"

namespace ratslam {
namespace {

/// Sum of numbers, each with a weight in [-1, 1) that depends on its place among them.
class WeightedSum {
 public:
  void add(double value) { sum_ += (2.0 * unitFromHash(mixBits(count_++)) - 1.0) * value; }
  double value() const { return sum_; }

 private:
  double sum_ = 0.0;
  std::uint64_t count_ = 0;
};

double sumOf(const Texture& texture) {
  WeightedSum sum;
  const auto size = static_cast<float>(texture.size());
  for (int row = 0; row < texture.size(); ++row)
    for (int column = 0; column < texture.size(); ++column)
      sum.add(texture.sampleLevel((static_cast<float>(column) + 0.5F) / size,
                                  (static_cast<float>(row) + 0.5F) / size, 0));
  return sum.value();
}

TEST(SameTown, OneSeedGivesTheSameTextures) {
  const TextureLibrary textures(1);
  EXPECT_NEAR(sumOf(textures[textures.asphalt(0)]), -49260.2, 20.0);
  EXPECT_NEAR(sumOf(textures[textures.leaves(0)]), -22984.7, 20.0);
  EXPECT_NEAR(sumOf(textures[textures.roof(0)]), -23335.4, 20.0);
  EXPECT_NEAR(sumOf(textures[textures.sign(0)]), -5880.5, 20.0);
  EXPECT_NEAR(sumOf(textures[textures.bareWall(1)]), -32534.2, 20.0);   // patches
  EXPECT_NEAR(sumOf(textures[textures.window(2, 4)]), -49759.5, 20.0);  // flowers
  EXPECT_NEAR(sumOf(textures[textures.skyline(0)]), -8817.5, 20.0);
}

TEST(SameTown, OneSeedGivesTheSameBodies) {
  const TownFixture fixture;
  std::size_t count = 0;
  WeightedSum bodies;
  for (const Town::Chunk& chunk : fixture.town.chunks())
    for (const MeshTriangle& triangle : chunk.triangles) {
      ++count;
      bodies.add(triangle.texture);
      for (const MeshVertex& vertex : triangle.corner)
        for (const double number : {vertex.position.x(), vertex.position.y(), vertex.position.z(),
                                    vertex.texture.x(), vertex.texture.y(), vertex.light})
          bodies.add(number);
      bodies.add(triangle.stain_offset.x());
      bodies.add(triangle.stain_offset.y());
    }
  EXPECT_EQ(count, 134900U);
  EXPECT_NEAR(bodies.value(), 45725.1, 1.0);
}

}  // namespace
}  // namespace ratslam
