#include "ratslam/local_view/recall/place_graph.h"

#include <algorithm>
#include <cmath>

namespace ratslam {
namespace {

constexpr std::size_t kMostAround = 48;

}  // namespace

void PlaceGraph::visit(std::uint32_t place, const DeadReckoning& where) {
  PlaceVisit& visit = visits_[place];
  visit.x = static_cast<float>(where.x);
  visit.y = static_cast<float>(where.y);
  visit.forward_variance = static_cast<float>(where.forward_variance);
  visit.yaw_variance = static_cast<float>(where.yaw_variance);
  visit.heading = static_cast<float>(where.heading);
  visit.turned = static_cast<float>(where.turned);
  visit.way = where.way;
  visit.epoch = where.epoch;
}

/// Calls visit(neighbour, signed distance) for all links of a place, in a fixed order.
template <class Visit>
void PlaceGraph::eachNeighbour(std::uint32_t place, Visit&& visit) const {
  if (visits_[place].to_next >= 0.0F) visit(place + 1, static_cast<double>(visits_[place].to_next));
  if (place > 0 && visits_[place - 1].to_next >= 0.0F) {
    visit(place - 1, -static_cast<double>(visits_[place - 1].to_next));
  }
  const auto [first, last] = others_.equal_range(place);
  if (first == last) return;
  std::vector<PlaceAhead> sorted;
  for (auto it = first; it != last; ++it) sorted.push_back(it->second);
  std::sort(sorted.begin(), sorted.end(),
            [](const PlaceAhead& a, const PlaceAhead& b) { return a.place < b.place; });
  for (const PlaceAhead& other : sorted) visit(other.place, other.distance);
}

void PlaceGraph::link(std::uint32_t from, std::uint32_t to, double distance, double novelty) {
  bool known = from == to;
  eachNeighbour(from, [&](std::uint32_t place, double) { known = known || place == to; });
  if (known) return;
  if (to == from + 1 && distance >= 0.0) {
    visits_[from].to_next = static_cast<float>(distance);
    visits_[from].novelty = static_cast<float>(novelty);
    return;
  }
  links_.push_back({from, to, distance});
  others_.emplace(from, PlaceAhead{to, distance});
  others_.emplace(to, PlaceAhead{from, -distance});
}

void PlaceGraph::indexLinks() {
  others_.clear();
  for (const Link& link : links_) {
    others_.emplace(link.from, PlaceAhead{link.to, link.distance});
    others_.emplace(link.to, PlaceAhead{link.from, -link.distance});
  }
}

void PlaceGraph::around(std::uint32_t place, double behind, double ahead,
                        std::vector<PlaceAhead>& found) const {
  found.clear();
  found.push_back({place, 0.0});
  for (std::size_t next = 0; next < found.size() && found.size() < kMostAround; ++next) {
    const PlaceAhead from = found[next];
    const bool expands = from.distance <= ahead && from.distance >= -behind;
    if (!expands) continue;
    eachNeighbour(from.place, [&](std::uint32_t other, double distance) {
      // Only outwards: the search does not turn back.
      const bool outwards = from.distance == 0.0 || (from.distance > 0.0) == (distance > 0.0);
      const auto same = [other](const PlaceAhead& seen) { return seen.place == other; };
      if (!outwards || std::any_of(found.begin(), found.end(), same)) return;
      found.push_back({other, from.distance + distance});
    });
  }
}

void PlaceGraph::within(std::uint32_t place, int links, double novelty,
                        std::vector<std::uint32_t>& found) const {
  struct Reached {
    std::uint32_t place = 0;
    int links = 0;
    double novelty = 0.0;
  };
  std::vector<Reached> reached{{place, 0, 0.0}};
  for (std::size_t next = 0; next < reached.size() && reached.size() < kMostAround; ++next) {
    const Reached from = reached[next];
    eachNeighbour(from.place, [&](std::uint32_t other, double) {
      const bool in_chain = other + 1 == from.place || from.place + 1 == other;
      const double between =
          in_chain ? static_cast<double>(visits_[std::min(other, from.place)].novelty) : 1.0;
      const Reached to{other, from.links + 1, from.novelty + between};
      const auto same = [other](const Reached& seen) { return seen.place == other; };
      if (to.links > links && !(to.novelty < novelty)) return;
      if (std::none_of(reached.begin(), reached.end(), same)) reached.push_back(to);
    });
  }
  found.clear();
  for (const Reached& seen : reached) found.push_back(seen.place);
}

double PlaceGraph::spacing(std::uint32_t place) const {
  double sum = 0.0;
  int count = 0;
  eachNeighbour(place, [&](std::uint32_t, double distance) {
    sum += std::abs(distance);
    ++count;
  });
  return count == 0 ? 0.0 : sum / count;
}

double PlaceGraph::stretch(std::uint32_t place, double least, std::size_t end) const {
  double sum = 0.0;
  double behind = 0.0;
  int count = 0;
  eachNeighbour(place, [&](std::uint32_t other, double distance) {
    behind = std::max(behind, -distance);
    if (distance <= 0.0 || other >= end) return;
    sum += distance;
    ++count;
  });
  return count > 0 ? sum / count : std::max(behind, least);
}

std::size_t PlaceGraph::memoryBytes() const {
  return visits_.capacity() * sizeof(PlaceVisit) + links_.capacity() * sizeof(Link) +
         others_.size() * (sizeof(std::pair<std::uint32_t, PlaceAhead>) + 2 * sizeof(void*));
}

}  // namespace ratslam
