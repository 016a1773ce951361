#include "engine/generator/invasion.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <queue>
#include <tuple>

#include "engine/base/math.hpp"
#include "engine/base/random.hpp"
#include "engine/generator/growth.hpp"
#include "engine/generator/near_points.hpp"

namespace hoodoo::generator {
namespace {

struct Candidate {
  std::uint32_t parent = Passage::none;  // a candidate
  std::uint32_t start = 0, number = 0;
  double length = 0, depth = 0;  // [m]
  float resistance = 0;
  bool covered = false;
  std::uint32_t passage = Passage::none;  // once it is one
};

/// Least first.
struct Waiting {
  double key;
  std::uint32_t start, number, candidate;
  friend bool operator>(const Waiting& a, const Waiting& b) {
    return std::tie(a.key, a.start, a.number) > std::tie(b.key, b.start, b.number);
  }
};

class Invader {
 public:
  Invader(std::span<const Vec3> starts, const InvasionRules& rules, const InvadedRock& rock,
          std::size_t most)
      : starts_(starts),
        rules_(rules),
        rock_(rock),
        most_(most),
        near_(rules.exclusion + rules.step),
        numbers_(starts.size()),
        carved_(starts.size()),
        reached_(rules.resurgences.size(), Passage::none) {}

  Invasion run() {
    for (std::uint32_t s = 0; s < starts_.size(); ++s) begin(s);
    while (!queue_.empty()) {
      const auto next = queue_.top().candidate;
      queue_.pop();
      if (carved_[all_[next].start] >= rules_.count) {
        refuse(Refusal::many);
        continue;
      }
      carve(next);
      if (!end_at_resurgence(next)) spread(next);
    }
    return std::move(made_);
  }

 private:
  const Vec3& at(std::uint32_t candidate) const { return near_.points()[candidate]; }
  void refuse(Refusal why) { ++made_.refused[static_cast<std::size_t>(why)]; }

  void begin(std::uint32_t s) {
    const Vec3& p = starts_[s];
    Candidate start;
    start.start = s;
    start.depth = rock_.depth(p);
    rock_.resistances({&p, 1}, {&start.resistance, 1});
    gather(p);
    std::optional<Refusal> why;
    if (std::isnan(start.depth)) {
      why = Refusal::outside;
    } else if (start.depth > rules_.depth) {
      why = Refusal::deep;
    } else if (static_cast<double>(start.resistance) >= rules_.rho_0) {
      why = Refusal::hard;
    } else if (crowded(p, Passage::none)) {
      why = Refusal::crowded;
    }
    if (why) {
      made_.start_refusals.push_back(*why);
      return;
    }
    start.covered = start.depth >= cover_at(p);
    add(p, start);
  }

  void add(const Vec3& p, Candidate one) {
    one.number = numbers_[one.start]++;
    const auto index = static_cast<std::uint32_t>(all_.size());
    const double u = unit_real(candidate_bits(rules_.seed, starts_[one.start], one.number, 0));
    const double key = static_cast<double>(one.resistance) * (1 + rules_.epsilon * u);
    queue_.push({key, one.start, one.number, index});
    near_.add(p);
    all_.push_back(one);
    ++made_.candidates;
  }

  void carve(std::uint32_t index) {
    auto& one = all_[index];
    expect_few(made_.passages.size() + 1, most_, "passages");
    one.passage = static_cast<std::uint32_t>(made_.passages.size());
    const auto parent = one.parent == Passage::none ? Passage::none : all_[one.parent].passage;
    made_.passages.push_back({at(index), parent, one.start, one.length, one.resistance});
    ++carved_[one.start];
  }

  /// The nearest resurgence and its distance.
  std::pair<std::size_t, double> resurgence(const Vec3& p) const {
    std::pair<std::size_t, double> best{0, std::numeric_limits<double>::infinity()};
    for (std::size_t i = 0; i < rules_.resurgences.size(); ++i) {
      const double d = length(rules_.resurgences[i] - p);
      if (d < best.second) best = {i, d};
    }
    return best;
  }

  /// Less and less cover is asked for on the way out to a resurgence.
  double cover_at(const Vec3& p) const {
    if (rules_.resurgences.empty()) return rules_.cover;
    return std::min(rules_.cover, std::max(0.0, (resurgence(p).second - rules_.step) / 2));
  }

  bool end_at_resurgence(std::uint32_t index) {
    if (rules_.resurgences.empty()) return false;
    const auto [i, d] = resurgence(at(index));
    if (d > rules_.step) return false;
    const Candidate last = all_[index];
    if (reached_[i] == Passage::none) {
      const Vec3& p = rules_.resurgences[i];
      float rho = 0;
      rock_.resistances({&p, 1}, {&rho, 1});
      reached_[i] = static_cast<std::uint32_t>(made_.passages.size());
      made_.passages.push_back({p, last.passage, last.start, last.length + d, rho});
    } else {
      made_.joins.emplace_back(last.passage, reached_[i]);
    }
    return true;
  }

  /// Keeps the candidates and passages that one a step from `p` can be too near to.
  void gather(const Vec3& p) {
    around_.clear();
    near_.visit(p, rules_.exclusion + rules_.step, [&](std::uint32_t i) {
      // Of a start that is done, what waits will never be carved.
      const auto& one = all_[i];
      if (one.passage == Passage::none && carved_[one.start] >= rules_.count) return;
      around_.emplace_back(near_.points()[i], i);
    });
  }
  bool crowded(const Vec3& p, std::uint32_t parent) const {
    const double least = rules_.exclusion * rules_.exclusion;
    return std::ranges::any_of(around_, [&](const auto& other) {
      const Vec3 d = other.first - p;
      return dot(d, d) < least && other.second != parent;
    });
  }

  /// What a place lacks to be a passage after `parent`, but for its rock.
  std::optional<Refusal> place(const Vec3& p, const Candidate& parent, Candidate& child) const {
    child.depth = rock_.depth(p);
    if (std::isnan(child.depth)) return Refusal::outside;
    if (child.depth > rules_.depth) return Refusal::deep;
    child.covered = child.depth >= cover_at(p);
    const bool descends = !parent.covered && child.depth >= parent.depth + rules_.step / 2;
    if (!child.covered && !descends) return Refusal::shallow;
    return std::nullopt;
  }

  /// Towards the nearest resurgence, as far as it may go up.
  Vec3 pulled(const Vec3& direction, const Vec3& p) const {
    if (rules_.resurgences.empty()) return direction;
    const Vec3 to = rules_.resurgences[resurgence(p).first] - p;
    Vec3 d = normalized(direction + rules_.pull * normalized(to), direction);
    const double plan = std::sqrt(d.x * d.x + d.y * d.y);
    if (d.z <= rules_.upward) return d;
    if (plan == 0) return direction;
    const double wide = std::sqrt(1 - rules_.upward * rules_.upward) / plan;
    return {d.x * wide, d.y * wide, rules_.upward};
  }

  void spread(std::uint32_t index) {
    const Candidate parent = all_[index];
    const Vec3 from = at(index);
    Candidate child;
    child.parent = index;
    child.start = parent.start;
    child.length = parent.length + rules_.step;
    if (child.length > rules_.length) return refuse(Refusal::far);
    gather(from);
    places_.clear();
    children_.clear();
    for (int k = 1; k <= rules_.directions; ++k) {
      const auto bits = candidate_bits(rules_.seed, starts_[parent.start], parent.number, k);
      const Vec3 p = from + rules_.step * pulled(direction_below(bits, rules_.upward), from);
      const auto why = crowded(p, index) ? Refusal::crowded : place(p, parent, child);
      if (why) {
        refuse(*why);
        continue;
      }
      places_.push_back(p);
      children_.push_back(child);
    }
    if (places_.empty()) return;
    resistances_.resize(places_.size());
    rock_.resistances(places_, resistances_);
    for (std::size_t i = 0; i < places_.size(); ++i) {
      children_[i].resistance = resistances_[i];
      if (static_cast<double>(resistances_[i]) >= rules_.rho_0) {
        refuse(Refusal::hard);
      } else if (crowded(places_[i], index)) {
        refuse(Refusal::crowded);
      } else {
        around_.emplace_back(places_[i], static_cast<std::uint32_t>(all_.size()));
        add(places_[i], children_[i]);
      }
    }
  }

  std::span<const Vec3> starts_;
  const InvasionRules& rules_;
  const InvadedRock& rock_;
  std::size_t most_;
  NearPoints near_;
  std::vector<Candidate> all_;
  std::priority_queue<Waiting, std::vector<Waiting>, std::greater<>> queue_;
  std::vector<std::uint32_t> numbers_, carved_;  // by start
  std::vector<std::uint32_t> reached_;           // passage at each resurgence
  std::vector<std::pair<Vec3, std::uint32_t>> around_;
  std::vector<Vec3> places_;
  std::vector<Candidate> children_;
  std::vector<float> resistances_;
  Invasion made_;
};

}  // namespace

Vec3 direction_below(std::uint64_t bits, double upward) {
  const double z = -1 + (1 + upward) * unit_real(bits);
  const double turn = 2 * pi * unit_real(mix(bits + 1));
  const double plan = std::sqrt(std::max(0.0, 1 - z * z));
  return {plan * bit_cos(turn), plan * bit_sin(turn), z};
}

std::uint64_t candidate_bits(std::uint64_t seed, const Vec3& start, std::uint32_t number, int k) {
  return random_bits(seed, std::bit_cast<std::uint64_t>(start.x + 0.0),
                     std::bit_cast<std::uint64_t>(start.y + 0.0),
                     std::bit_cast<std::uint64_t>(start.z + 0.0), number, k);
}

Invasion invade(std::span<const Vec3> starts, const InvasionRules& rules, const InvadedRock& rock,
                std::size_t most) {
  return Invader(starts, rules, rock, most).run();
}

}  // namespace hoodoo::generator
