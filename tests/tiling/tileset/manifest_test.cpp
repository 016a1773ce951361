#include "tiling/tileset/manifest.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "engine/base/file.hpp"
#include "tests/tiling/tileset/world.hpp"

namespace hoodoo::tileset {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using shapes::Folder;
using shapes::World;
using testing::HasSubstr;

constexpr IndexSettings lines{.lines_past = 5};

std::vector<json> lines_of(const fs::path& folder) {
  std::istringstream text(read_file(folder / "bake.json", 1U << 30));
  std::vector<json> found;
  for (std::string line; std::getline(text, line);) found.push_back(json::parse(line));
  return found;
}

std::string refusal(const fs::path& folder) {
  try {
    read_bake(folder);
  } catch (const Error& error) {
    EXPECT_EQ(error.fault, Fault::bad_input);
    return error.what();
  }
  return "";
}

TEST(Manifest, HasALineForEachTileOfALargePlan) {
  const Folder folder("lines");
  Bake bake = World{.levels = 3}.make(folder.path);
  std::erase_if(bake.records, [](const Record& r) { return r.key == plan::Key{0, 1, 2}; });
  write_index(bake, estimate_errors(bake), folder.path, lines);
  const auto found = lines_of(folder.path);
  ASSERT_EQ(found.size(), 1 + bake.planned.size());
  EXPECT_EQ(found[0].at("format"), 2);
  EXPECT_EQ(found[0].at("planned"), bake.planned.size());
  EXPECT_FALSE(found[0].contains("tiles"));
  EXPECT_FALSE(found[0].contains("missing"));
  for (std::size_t i = 1; i < found.size(); ++i) {
    EXPECT_EQ(found[i].at("key"), bake.planned[i - 1].text());  // planned by key
    EXPECT_EQ(found[i].contains("missing"), bake.planned[i - 1] == (plan::Key{0, 1, 2}));
  }
}

TEST(Manifest, SaysTheSameInBothForms) {
  const Folder document("document"), jsonl("jsonl");
  for (const bool complete : {true, false}) {
    for (const auto* folder : {&document, &jsonl}) {
      Bake bake = World{.levels = 3}.make(folder->path);
      bake.scene = sha256("scene");
      if (!complete) std::erase_if(bake.records, [](const Record& r) { return r.key.x == 1; });
      const auto errors = complete ? measure_errors(bake, folder->path, 2) : estimate_errors(bake);
      write_index(bake, errors, folder->path, folder == &jsonl ? lines : IndexSettings{});
    }
    const Bake one = read_bake(document.path), other = read_bake(jsonl.path);
    EXPECT_EQ(one.records, other.records);
    EXPECT_EQ(one.planned, other.planned);
    EXPECT_EQ(one.scene, other.scene);
    const auto first = read_manifest(document.path), second = read_manifest(jsonl.path);
    EXPECT_EQ(first.errors, second.errors);
    EXPECT_EQ(first.complete, complete);
    EXPECT_EQ(second.complete, complete);
    EXPECT_EQ(read_file(document.path / "tileset.json", 1U << 30),
              read_file(jsonl.path / "tileset.json", 1U << 30));
    EXPECT_TRUE(verify(jsonl.path).problems.empty());
  }
}

TEST(Manifest, IsTakenOverFromLines) {
  const Folder folder("taken-over");
  const Bake bake = World{.levels = 3}.make(folder.path);
  const auto errors = measure_errors(bake, folder.path, 1);
  write_index(bake, errors, folder.path, lines);
  fs::remove_all(folder.path / "tiles");  // nothing is read again
  EXPECT_EQ(measure_errors(bake, folder.path, 2), errors);
}

TEST(Manifest, FindsARecordAgainByItsPlace) {
  for (const auto& form : {lines, IndexSettings{}}) {
    const Folder folder("places");
    const Bake bake = World{.levels = 3}.make(folder.path);
    write_index(bake, estimate_errors(bake), folder.path, form);
    ManifestReader reader(folder.path);
    std::vector<ManifestReader::Entry> entries;
    while (auto entry = reader.next()) {
      entries.push_back(*entry);
      EXPECT_EQ(reader.record_at(entries.front().at), entries.front().record);
    }
    ASSERT_EQ(entries.size(), bake.planned.size());
    for (const auto& entry : entries) EXPECT_EQ(reader.record_at(entry.at), entry.record);
  }
}

TEST(Manifest, RefusesDamagedLines) {
  const Folder folder("damaged-lines");
  const Bake bake = World{.levels = 3}.make(folder.path);
  write_index(bake, estimate_errors(bake), folder.path, lines);
  const auto good = read_file(folder.path / "bake.json", 1U << 30);
  EXPECT_EQ(refusal(folder.path), "");
  const auto spoilt = [&](const std::function<void(std::vector<std::string>&)>& change) {
    std::istringstream text(good);
    std::vector<std::string> all;
    for (std::string line; std::getline(text, line);) all.push_back(line);
    change(all);
    std::string joined;
    for (const auto& line : all) joined += line + "\n";
    write_file(folder.path / "bake.json", joined);
    return refusal(folder.path);
  };
  EXPECT_THAT(spoilt([](auto& l) { l.pop_back(); }), HasSubstr("every tile that is planned"));
  EXPECT_THAT(spoilt([](auto& l) { l[4] = l[3]; }), HasSubstr("lists a tile twice: "));
  EXPECT_THAT(spoilt([](auto& l) { std::swap(l[4], l[3]); }), HasSubstr("does not list by key"));
  EXPECT_THAT(spoilt([](auto& l) { l.back().resize(40); }), HasSubstr("ends too early"));
  EXPECT_THAT(spoilt([](auto& l) { l[2] = "7"; }), HasSubstr("must have a text \"key\""));
  EXPECT_THAT(spoilt([](auto& l) { l[2] = "]"; }), HasSubstr("a bracket closes nothing"));
  EXPECT_THAT(spoilt([](auto& l) {
                auto head = json::parse(l[0]);
                head["format"] = 3;
                l[0] = head.dump();
              }),
              HasSubstr("list of tiles"));
}

TEST(Manifest, OfAnyLayoutIsRead) {
  const Folder folder("layout");
  const Bake bake = World{.levels = 2}.make(folder.path);
  write_index(bake, estimate_errors(bake), folder.path);
  const auto document = json::parse(read_file(folder.path / "bake.json", 1U << 30));
  for (const int indent : {-1, 0, 4}) {
    json turned = document;
    turned["name"] = "brackets ] } and \"quotes\\\" in a name";
    write_file(folder.path / "bake.json", turned.dump(indent));
    EXPECT_EQ(read_bake(folder.path).records, bake.records) << indent;
  }
}

}  // namespace
}  // namespace hoodoo::tileset
