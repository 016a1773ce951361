#include "engine/scene/ball_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <memory>
#include <utility>
#include <variant>
#include <vector>

#include "engine/base/lock.hpp"
#include "engine/tree/ball_file.hpp"
#include "engine/tree/read_fields.hpp"

namespace hoodoo::scene {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 5> columns{"x", "y", "z", "radius", "energy"};
constexpr std::size_t longest_row = 1000;  // [bytes]
constexpr std::size_t most_rows = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t most_told = 20;  // problems of a file
constexpr std::size_t bytes_per_ball = 44;

/// Calls `ball(it)` for each row; problems go to `tell(what)`, until that says to stop.
class Rows {
 public:
  Rows(const fs::path& file, std::function<void(const tree::Ball&)> ball,
       std::function<bool(const std::string&)> tell)
      : file_(file, std::ios::binary), ball_(std::move(ball)), tell_(std::move(tell)) {}

  void run() {
    if (!file_) {
      tell_("cannot be read");
      return;
    }
    if (!next() || !read_head()) {
      tell_("must begin with the line x,y,z,radius or x,y,z,radius,energy");
      return;
    }
    while (next()) {
      if (line_.empty()) continue;
      if (++balls_ > most_rows) {
        tell_(fmt::format("has more than {} rows", most_rows));
        return;
      }
      if (!read_row()) return;
    }
    if (balls_ == 0) tell_("holds no ball");
  }

 private:
  bool next() {
    if (!std::getline(file_, line_)) return false;
    ++row_;
    if (!line_.empty() && line_.back() == '\r') line_.pop_back();
    return true;
  }

  bool read_head() {
    std::string bare;
    std::ranges::copy_if(line_, std::back_inserter(bare), [](char c) { return c != ' '; });
    if (bare != "x,y,z,radius" && bare != "x,y,z,radius,energy") return false;
    count_ = bare.ends_with("energy") ? 5 : 4;
    return true;
  }

  /// False when enough was told.
  bool read_row() {
    std::array<double, 5> numbers{0, 0, 0, 1, 1};
    std::string_view rest = std::string_view(line_).substr(0, longest_row);
    bool good = true;
    for (std::size_t k = 0; k < count_; ++k) {
      const auto comma = rest.find(',');
      if ((comma == rest.npos) != (k + 1 == count_)) {
        return tell_(fmt::format("row {} must have {} columns", row_, count_));
      }
      auto text = rest.substr(0, comma);
      if (comma != rest.npos) rest.remove_prefix(comma + 1);
      while (text.starts_with(' ')) text.remove_prefix(1);
      while (text.ends_with(' ')) text.remove_suffix(1);
      const auto problem = read_number(text, k, numbers[k]);
      if (problem.empty()) continue;
      good = false;
      if (!tell_(fmt::format("row {}, column {}: {}, got {}", row_, columns[k], problem,
                             text.substr(0, 40)))) {
        return false;
      }
    }
    const auto [x, y, z, radius, energy] = numbers;
    if (good) ball_({{x, y, z}, radius, static_cast<float>(energy)});
    return true;
  }

  /// What is wrong with it; "" when nothing is.
  static std::string read_number(std::string_view text, std::size_t column, double& number) {
    const auto& range = tree::ball_ranges[column];
    const auto read = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = read.ec == std::errc() && read.ptr == text.data() + text.size();
    if (!whole || !std::isfinite(number)) return "must be a number";
    std::vector<Problem> problems;
    tree::read_number(nlohmann::json(number), "", range, column < 4 ? "m" : "1", problems);
    if (problems.empty()) return "";
    const auto& what = problems.front().what;
    return what.substr(0, what.rfind(", got"));
  }

  std::ifstream file_;
  std::function<void(const tree::Ball&)> ball_;
  std::function<bool(const std::string&)> tell_;
  std::string line_;
  std::size_t row_ = 0, count_ = 0, balls_ = 0;
};

template <class Visit>
void for_each_file_name(tree::Node& tree, const Visit& visit) {
  std::visit(
      [&](auto& node) {
        if constexpr (requires { node.balls.size(); }) visit(node.file, node.balls);
      },
      tree.value);
  for (auto& child : tree.children) for_each_file_name(child, visit);
}

/// Balls from a file named by their digest, which `fill` writes unless it is there.
template <class Fill>
tree::Balls file_of(const Digest& digest, const fs::path& folder, std::size_t memory,
                    std::set<fs::path>& kept, const Fill& fill) {
  const auto place = folder / (digest.hex() + ".balls");
  kept.insert(place.filename());
  std::error_code error;
  fs::create_directories(folder, error);
  const FileLock lock(place.string() + ".lock", FileLock::Kind::exclusive, {});
  kept.insert(place.filename().string() + ".lock");
  if (!fs::exists(place, error)) {
    tree::BallFileWriter writer(place, memory);
    fill(writer);
    writer.finish();
  }
  return tree::Balls(std::make_shared<const tree::BallFile>(place));
}

}  // namespace

std::size_t most_balls_in(std::size_t memory) { return memory / bytes_per_ball; }

tree::Balls in_file(const tree::Balls& balls, const fs::path& folder, std::size_t memory,
                    std::set<fs::path>& kept) {
  return file_of(balls.digest(), folder, memory, kept, [&](tree::BallFileWriter& writer) {
    for (const auto& ball : balls.list()) writer.add(ball);
  });
}

std::optional<double> BallFiles::check(const std::string& file, const std::string& where) {
  if (const auto known = known_.find(file); known != known_.end()) {
    return known->second.least_radius;
  }
  // A definition that does not fit one family of trees is read as the other.
  if (!told_.insert(where).second) return std::nullopt;
  const auto at = where + "/file";
  const auto path = find_file(file, at, sources_, findings_);
  if (!path) return std::nullopt;
  BallFacts facts{*path, 0, std::numeric_limits<double>::infinity(), {}};
  tree::BallDigest digest;
  std::size_t told = 0;
  const auto add = [&](const tree::Ball& ball) {
    ++facts.size;
    facts.least_radius = std::min(facts.least_radius, ball.radius);
    digest.add(ball);
  };
  const auto tell = [&](const std::string& what) {
    findings_.problems.push_back({at, fmt::format("\"{}\": {}", file, what)});
    return ++told < most_told;
  };
  Rows(*path, add, tell).run();
  if (told > 0) return std::nullopt;
  facts.digest = digest.finish();
  return known_.emplace(file, std::move(facts)).first->second.least_radius;
}

void BallLoader::load(tree::Node& tree) {
  for_each_file_name(tree, [&](std::string& file, tree::Balls& into) {
    if (file.empty()) return;
    into = balls(file);
    file.clear();
  });
}

tree::Balls BallLoader::balls(const std::string& file) {
  if (const auto found = loaded_.find(file); found != loaded_.end()) return found->second;
  const auto& facts = files_.at(file);
  const auto changed = [&](const std::string& what) {
    return Error(Fault::bad_input, facts.path.string(), "was changed while it was read: " + what);
  };
  const auto refuse = [&](const std::string& what) -> bool { throw changed(what); };
  tree::Balls balls;
  if (facts.size <= most_ / bytes_per_ball) {
    std::vector<tree::Ball> list;
    list.reserve(facts.size);
    Rows(
        facts.path, [&](const tree::Ball& ball) { list.push_back(ball); }, refuse)
        .run();
    balls = tree::Balls(list);
  } else {
    balls = file_of(facts.digest, folder_, memory_, kept_, [&](tree::BallFileWriter& writer) {
      Rows(
          facts.path, [&](const tree::Ball& ball) { writer.add(ball); }, refuse)
          .run();
    });
  }
  if (balls.digest() != facts.digest) throw changed("other balls");
  return loaded_.emplace(file, std::move(balls)).first->second;
}

}  // namespace hoodoo::scene
