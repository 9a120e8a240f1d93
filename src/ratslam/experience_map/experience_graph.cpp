#include "ratslam/experience_map/experience_graph.h"

#include <stdexcept>
#include <string>

#include "ratslam/common/state.h"

namespace ratslam {

std::uint32_t ExperienceGraph::addExperience(const MapPose& pose) {
  Experience experience;
  experience.pose = pose;
  experiences_.push_back(experience);
  ++revision_;
  return static_cast<std::uint32_t>(experiences_.size() - 1);
}

std::uint32_t ExperienceGraph::addLink(Link link) {
  if (link.from >= experiences_.size() || link.to >= experiences_.size() || link.from == link.to) {
    throw std::invalid_argument("link from experience " + std::to_string(link.from) + " to " +
                                std::to_string(link.to) + ": it must join two of the " +
                                std::to_string(experiences_.size()) + " experiences");
  }
  const auto id = static_cast<std::uint32_t>(links_.size());
  link.next_outgoing = link.next_incoming = kNoLink;
  links_.push_back(link);
  Experience& from = experiences_[link.from];
  Experience& to = experiences_[link.to];
  (from.last_outgoing == kNoLink ? from.first_outgoing : links_[from.last_outgoing].next_outgoing) = id;
  (to.last_incoming == kNoLink ? to.first_incoming : links_[to.last_incoming].next_incoming) = id;
  from.last_outgoing = id;
  to.last_incoming = id;
  ++revision_;
  return id;
}

bool ExperienceGraph::linked(std::uint32_t a, std::uint32_t b) const {
  return linkStarts(a, b) || linkStarts(b, a);
}

bool ExperienceGraph::linkStarts(std::uint32_t from, std::uint32_t to) const {
  for (std::uint32_t k = experiences_.at(from).first_outgoing; k != kNoLink; k = links_[k].next_outgoing) {
    if (links_[k].to == to) return true;
  }
  return false;
}

void ExperienceGraph::save(State& state) const {
  state.set("experiences", experiences_);
  state.set("links", links_);
  state.set("revision", revision_);
}

void ExperienceGraph::load(const State& state) {
  ExperienceGraph loaded;
  for (const Experience& experience : state.get<std::vector<Experience>>("experiences")) {
    loaded.addExperience(experience.pose);
  }
  try {
    for (const Link& link : state.get<std::vector<Link>>("links")) loaded.addLink(link);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error("state " + state.path() + ": " + error.what());
  }
  state.get("revision", loaded.revision_);
  *this = std::move(loaded);
}

}  // namespace ratslam
