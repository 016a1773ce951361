#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <span>

#include "tiling/compare/compare.hpp"

namespace hoodoo::compare {
namespace {

using nlohmann::json;
using Change = Tile::Change;

const char* name_of(Change change) {
  switch (change) {
    case Change::added:
      return "added";
    case Change::gone:
      return "gone";
    case Change::changed:
      break;
  }
  return "changed";
}

json to_json(const Tile& tile, bool by_region) {
  json result{{"key", tile.key.text()}, {"change", name_of(tile.change)}, {"beyond", tile.beyond}};
  if (tile.change != Change::changed) return result;
  result["largest"] = tile.largest;
  result["mean"] = tile.mean;
  if (by_region) return result;
  result["normal"] = tile.normal;
  result["material"] = tile.material;
  return result;
}

json levels_of(const Comparison& comparison) {
  std::map<int, int> changed;
  for (const auto& tile : comparison.tiles) {
    if (tile.change == Change::changed) ++changed[tile.key.level];
  }
  json levels = json::array();
  for (const auto& [level, count] : changed) {
    levels.push_back({{"level", level},
                      {"changed", count},
                      {"largest", comparison.largest(level)},
                      {"mean", comparison.mean(level)}});
  }
  return levels;
}

std::string base64(std::span<const unsigned char> bytes) {
  constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t count = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | (k < count ? bytes[i + k] : 0U);
    for (std::size_t k = 0; k < 4; ++k) {
      text += k <= count ? digits[word >> (18 - 6 * k) & 63] : '=';
    }
  }
  return text;
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

constexpr std::size_t most_rows = 500;

constexpr const char* head = R"(<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>hoodoo diff</title>
<style>
body { font: 15px/1.45 system-ui, sans-serif; color: #222; background: #faf9f6; max-width: 60em; margin: 2em auto; padding: 0 1em; }
table { border-collapse: collapse; }
th, td { text-align: right; padding: .2em .8em; border-bottom: 1px solid #ddd; }
th:first-child, td:first-child, td:nth-child(2), th:nth-child(2) { text-align: left; }
.within td { color: #888; }
figure { margin: 1.5em 0; }
img { width: 49%; max-width: 400px; border: 1px solid #ddd; }
.ramp { display: inline-block; width: 8em; height: .8em; background: linear-gradient(90deg, #bcbcba, #f5be28, #be0f19); }
</style>
</head>
<body>
)";

std::string row(const Tile& tile, bool by_region) {
  std::string text =
      fmt::format("<tr{}><td>{}</td><td>{}</td>", tile.beyond ? "" : " class=\"within\"",
                  tile.key.text(), name_of(tile.change));
  const bool changed = tile.change == Change::changed;
  text += changed ? fmt::format("<td>{:.4g}</td><td>{:.4g}</td>", tile.largest, tile.mean)
                  : "<td></td><td></td>";
  if (!by_region) {
    text += changed
                ? fmt::format("<td>{:.1f}</td><td>{:.2f}</td>", tile.normal, 100 * tile.material)
                : "<td></td><td></td>";
  }
  return text + "</tr>\n";
}

std::string table(const Comparison& comparison) {
  if (comparison.tiles.empty()) return "";
  std::string text = fmt::format(
      "<table>\n<tr><th>{}</th><th>change</th><th>largest [m]</th><th>mean [m]</th>{}</tr>\n",
      comparison.by_region ? "region" : "tile",
      comparison.by_region ? "" : "<th>normal [&deg;]</th><th>material [%]</th>");
  for (std::size_t i = 0; i < std::min(most_rows, comparison.tiles.size()); ++i) {
    text += row(comparison.tiles[i], comparison.by_region);
  }
  text += "</table>\n";
  if (comparison.tiles.size() > most_rows) {
    text += fmt::format("<p>And {} more.</p>\n", comparison.tiles.size() - most_rows);
  }
  return text;
}

}  // namespace

json to_json(const Comparison& comparison) {
  json tiles = json::array();
  for (const auto& tile : comparison.tiles) tiles.push_back(to_json(tile, comparison.by_region));
  return {{"same", comparison.same()},
          {"tolerance", comparison.settings.tolerance},
          {"by", comparison.by_region ? "region" : "tile"},
          {"spacings", {comparison.first.spacing0, comparison.second.spacing0}},
          {"compared", comparison.compared},
          {"equal", comparison.compared - comparison.tiles.size()},
          {"changed", comparison.count(Change::changed)},
          {"added", comparison.count(Change::added)},
          {"gone", comparison.count(Change::gone)},
          {"beyond", comparison.beyond()},
          {"read", comparison.read},
          {"largest", comparison.largest(0)},
          {"mean", comparison.mean(0)},
          {"levels", levels_of(comparison)},
          {"tiles", tiles}};
}

std::string page(const Comparison& comparison, std::string_view first, std::string_view second) {
  std::string text = head;
  text +=
      fmt::format("<h1>{}</h1>\n<p>{} and {}</p>\n", comparison.same() ? "The same" : "Different",
                  escaped(first), escaped(second));
  for (const auto& line : summary(comparison)) text += "<p>" + escaped(line) + "</p>\n";
  for (const auto& view : comparison.views) {
    const auto tile = std::ranges::find(comparison.tiles, view.key, &Tile::key);
    text += fmt::format(
        "<figure><figcaption>{}: before and after, 0 <span class=\"ramp\"></span> {:.4g} "
        "m</figcaption>\n",
        view.key.text(), tile->largest);
    const char* when = "before";
    for (const auto* picture : {&view.first, &view.second}) {
      text += fmt::format("<img alt=\"{} {}\" src=\"data:image/png;base64,{}\">\n", view.key.text(),
                          when, base64(scene::png(*picture)));
      when = "after";
    }
    text += "</figure>\n";
  }
  return text + table(comparison) + "</body>\n</html>\n";
}

std::vector<std::string> summary(const Comparison& comparison) {
  const char* what = comparison.by_region ? "regions" : "tiles";
  std::vector<std::string> lines;
  if (comparison.by_region) {
    lines.push_back(fmt::format(
        "Their tiles do not match (spacing {} m and {} m): leaf surfaces compared over the ground "
        "both cover, by distance alone; regions are the leaves of the {} bake",
        comparison.first.spacing0, comparison.second.spacing0,
        comparison.regions_of_second ? "second" : "first"));
  }
  const auto differ = comparison.beyond();
  std::string line = fmt::format("{} of {} {} differ", differ, comparison.compared, what);
  if (comparison.settings.tolerance > 0) {
    line += fmt::format(" by more than {} m", comparison.settings.tolerance);
    if (!comparison.by_region)
      line += " (2^L times that at level L) or the material of 1 % of their area";
  }
  line += fmt::format(", {} added, {} gone", comparison.count(Change::added),
                      comparison.count(Change::gone));
  if (comparison.count(Change::changed) > 0) {
    line += fmt::format("; largest distance between leaves {:.4g} m", comparison.largest(0));
  }
  lines.push_back(line);
  return lines;
}

}  // namespace hoodoo::compare
