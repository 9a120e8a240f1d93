/// All textures of a town, painted from one seed: ground, walls, windows, doors, shop fronts, roofs, leaves,
/// cars, signs, clouds and the skyline.
#pragma once

#include <cstdint>
#include <vector>

#include "town/texture.h"

namespace ratslam {

class TextureLibrary {
 public:
  static constexpr int kAsphalts = 3, kRoofs = 4, kLeaves = 4, kPaints = 6, kSigns = 24, kSkylines = 4;
  static constexpr int kWalls = 10;
  /// One bay of one storey of a wall: bare, with one of several windows, a door or a shop front.
  static constexpr int kWindows = 5, kDoors = 2, kShops = 2;
  static constexpr int kBays = 1 + kWindows + kDoors + kShops;
  static constexpr double kBayMetres = 3.0;       ///< width and height a bay is painted for
  static constexpr double kAsphaltMetres = 12.8;  ///< edge of the asphalt and grass textures on the ground

  explicit TextureLibrary(std::uint64_t seed);

  const Texture& operator[](std::uint16_t id) const { return textures_[id]; }

  std::uint16_t asphalt(int kind) const { return id(asphalt_, kind); }
  std::uint16_t roof(int kind) const { return id(roof_, kind); }
  std::uint16_t leaves(int kind) const { return id(leaves_, kind); }
  std::uint16_t paint(int kind) const { return id(paint_, kind); }
  std::uint16_t sign(int kind) const { return id(sign_, kind); }
  std::uint16_t skyline(int face) const { return id(skyline_, face); }
  std::uint16_t bareWall(int wall) const { return id(walls_, wall * kBays); }
  std::uint16_t window(int wall, int kind) const { return id(walls_, wall * kBays + 1 + kind); }
  std::uint16_t door(int wall, int kind) const { return id(walls_, wall * kBays + 1 + kWindows + kind); }
  std::uint16_t shop(int wall, int kind) const {
    return id(walls_, wall * kBays + 1 + kWindows + kDoors + kind);
  }
  std::uint16_t pavement() const { return pavement_; }
  std::uint16_t grass() const { return grass_; }
  std::uint16_t kerb() const { return kerb_; }
  std::uint16_t marking() const { return marking_; }
  std::uint16_t manhole() const { return manhole_; }
  std::uint16_t bark() const { return bark_; }
  std::uint16_t planks() const { return planks_; }
  std::uint16_t plain() const { return plain_; }
  std::uint16_t carGlass() const { return car_glass_; }
  std::uint16_t carFront() const { return car_front_; }
  std::uint16_t carRear() const { return car_rear_; }
  std::uint16_t wheel() const { return wheel_; }
  std::uint16_t clouds() const { return clouds_; }
  std::uint16_t stains() const { return stains_; }

 private:
  static std::uint16_t id(std::uint16_t first, int kind) { return static_cast<std::uint16_t>(first + kind); }
  std::uint16_t add(Texture texture);
  void paintGround(std::uint64_t seed);
  void paintWalls(std::uint64_t seed);
  void paintObjects(std::uint64_t seed);
  void paintSky(std::uint64_t seed);

  std::vector<Texture> textures_;
  std::uint16_t asphalt_ = 0, roof_ = 0, leaves_ = 0, paint_ = 0, sign_ = 0, skyline_ = 0, walls_ = 0;
  std::uint16_t pavement_ = 0, grass_ = 0, kerb_ = 0, marking_ = 0, manhole_ = 0, bark_ = 0, planks_ = 0,
                plain_ = 0;
  std::uint16_t car_glass_ = 0, car_front_ = 0, car_rear_ = 0, wheel_ = 0, clouds_ = 0, stains_ = 0;
};

}  // namespace ratslam
