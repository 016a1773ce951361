#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <random>

#include "engine/base/error.hpp"
#include "engine/dem/chunks.hpp"
#include "engine/dem/crs.hpp"
#include "engine/dem/dem.hpp"
#include "engine/dem/keys.hpp"
#include "tests/engine/dem/pyramids.hpp"

namespace hoodoo::dem {
namespace {

TEST(Pyramid, HasTheSamplesThemselvesWhereRasterAndFrameAgree) {
  const ScratchFolder folder;
  const int width = 300, height = 270;
  const auto samples = hills(width, height, 0.01);
  const auto p = ingest(projected(folder, width, height, samples), folder / "cache");
  const auto& level = p->levels()[0];
  EXPECT_EQ(level.width, width);
  EXPECT_EQ(level.height, height);
  EXPECT_EQ(level.dx, 2);
  EXPECT_EQ(level.x0, 1);  // the origin is a multiple of the spacing
  const auto w = p->window(0, p->extent());
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) {
      const double x = level.x0 + (i + 0.5) * 2, y = level.y0 + (height - 1 - j + 0.5) * 2;
      const float sample = samples[static_cast<std::size_t>(j * width + i)];
      ASSERT_EQ(w.valid(x, y), !std::isnan(sample));
      if (!std::isnan(sample)) {
        ASSERT_EQ(w.height(x, y), static_cast<double>(sample));
      }
    }
  }
}

TEST(Pyramid, AveragesTheValidOnesOfFour) {
  const ScratchFolder folder;
  std::vector<float> samples{1, 2, 3, nan, 5, nan, 7, 8, 9, 10, nan, nan, 13, 14, nan, nan};
  const auto p = ingest(projected(folder, 4, 4, samples), folder / "cache");
  ASSERT_EQ(p->levels().size(), 2u);
  const auto& level = p->levels()[1];
  EXPECT_EQ(level.dx, 4);
  const auto w = p->window(1, p->extent());
  const auto at = [&](int i, int j) {
    return w.height(level.x0 + (i + 0.5) * 4, level.y0 + (j + 0.5) * 4);
  };
  EXPECT_FALSE(w.valid(level.x0 + 6, level.y0 + 2));
  EXPECT_EQ(at(0, 0), 11.5);
  EXPECT_EQ(at(0, 1), (1.0f + 2.0f + 5.0f) / 3.0f);
  EXPECT_EQ(at(1, 1), 6);
}

TEST(Pyramid, LevelsGoUntilTwoPixelsAndAreChosenBySpacing) {
  const ScratchFolder folder;
  const auto p = ingest(projected(folder, 300, 270, hills(300, 270)), folder / "cache");
  EXPECT_EQ(p->levels().size(), 9u);
  EXPECT_EQ(p->levels().back().width, 2);
  EXPECT_EQ(p->level_for(1), 0);
  EXPECT_EQ(p->level_for(2), 0);
  EXPECT_EQ(p->level_for(7.9), 1);
  EXPECT_EQ(p->level_for(8), 2);
  EXPECT_EQ(p->level_for(1e9), 8);
}

TEST(Pyramid, ResamplesDegreesToWhatTheSourceHoldsThere) {
  const ScratchFolder folder;
  // A plane in longitude and latitude: bicubic sampling reproduces it, so each pixel tells where
  // in the source it was taken.
  const int width = 400, height = 300;
  std::vector<float> samples;
  for (int j = 0; j < height; ++j) {
    for (int i = 0; i < width; ++i) samples.push_back(static_cast<float>(2 * i + 3 * j));
  }
  const auto path = geographic(folder, width, height, samples);
  const auto placed = place(*Raster::open(path), {});
  const auto p = ingest(path, folder / "cache");
  const Mapping mapping("EPSG:4326", placed.frame.crs, {8.2, 46.7});
  const auto w = p->window(0, p->extent());
  for (const double i : {20.5, 100.5, 377.5}) {
    for (const double j : {15.5, 140.5, 280.5}) {
      const auto at = mapping.forward({8.2 + i / 3600, 46.7 - j / 3600});
      ASSERT_TRUE(at);
      const double h = w.height(at->x - placed.frame.origin_x, at->y - placed.frame.origin_y);
      EXPECT_NEAR(h, 2 * (i - 0.5) + 3 * (j - 0.5), 5 * 0.01);
    }
  }
}

TEST(Pyramid, IsTheSameBytesForAnyThreadsAndMemory) {
  const ScratchFolder folder;
  const int width = 900, height = 1100;
  const auto samples = hills(width, height, 0.02);
  for (const auto& path :
       {geographic(folder, width, height, samples), projected(folder, width, height, samples)}) {
    std::map<std::string, std::string> first;
    int run = 0;
    for (const int threads : {1, 2, 5}) {
      for (const std::size_t memory : {std::size_t{1} << 20, std::size_t{256} << 20}) {
        const auto cache = folder / (path.stem().string() + std::to_string(run++));
        IngestSettings settings;
        settings.threads = threads;
        settings.memory = memory;
        ingest(path, cache, {}, settings);
        const auto now = contents(cache);
        EXPECT_GT(now.size(), 5u);
        if (first.empty()) first = now;
        EXPECT_EQ(first, now) << path << " threads " << threads << " memory " << memory;
      }
    }
  }
}

TEST(Pyramid, FillReplacesNoDataInsideTheRasterOnly) {
  const ScratchFolder folder;
  auto samples = hills(100, 100);
  for (int k = 4000; k < 6000; ++k) samples[static_cast<std::size_t>(k)] = nan;
  const auto path = geographic(folder, 100, 100, samples);
  const auto holes = ingest(path, folder / "cache");
  const auto filled = ingest(path, folder / "cache", -5.0);
  EXPECT_NE(holes->digest(), filled->digest());
  const auto box = holes->extent();
  const double x = 0.5 * (box.min.x + box.max.x), y = 0.5 * (box.min.y + box.max.y);
  EXPECT_FALSE(holes->window(0, box).valid(x, y));
  EXPECT_TRUE(filled->window(0, box).valid(x, y));
  EXPECT_NEAR(filled->window(0, box).height(x, y), -5, 1e-3);
  // The corner of the box lies outside the raster, which stands askew in it.
  const auto corner = filled->window(0, box);
  int outside = 0;
  const auto& level = filled->levels()[0];
  for (std::int64_t i = 0; i < level.width; ++i) {
    const double at = level.x0 + (static_cast<double>(i) + 0.5) * level.dx;
    outside += !corner.valid(at, box.max.y - 0.5 * level.dy);
  }
  EXPECT_GT(outside, 0);
}

TEST(Pyramid, WindowsAgreeToTheBitWhereverTheyAreCut) {
  const ScratchFolder folder;
  const auto p = ingest(projected(folder, 700, 600, hills(700, 600, 0.2)), folder / "cache");
  std::mt19937 random(11);
  for (const int level : {0, 1, 3}) {
    const auto box = p->extent().grown(10 * p->levels()[static_cast<std::size_t>(level)].dx);
    const auto whole = p->window(level, box);
    std::uniform_real_distribution<double> x(box.min.x, box.max.x), y(box.min.y, box.max.y);
    for (int k = 0; k < 50; ++k) {
      const double x0 = x(random), y0 = y(random);
      const auto part = area(x0, y0, std::min(box.max.x, x0 + 37), std::min(box.max.y, y0 + 51));
      const auto w = p->window(level, part);
      std::uniform_real_distribution<double> u(part.min.x, part.max.x), v(part.min.y, part.max.y);
      const auto bounds = w.bounds(part);
      for (int n = 0; n < 100; ++n) {
        const double px = n ? u(random) : part.max.x, py = n ? v(random) : part.max.y;
        const auto a = whole.at(px, py), b = w.at(px, py);
        ASSERT_EQ(a.h, b.h);
        ASSERT_EQ(a.hx, b.hx);
        ASSERT_EQ(a.hy, b.hy);
        ASSERT_EQ(whole.valid(px, py), w.valid(px, py));
        ASSERT_TRUE(bounds.contains(b.h));
      }
    }
  }
}

TEST(Pyramid, BoundsHoldTheElevationsNearValidPixels) {
  const ScratchFolder folder;
  const auto p = ingest(projected(folder, 700, 600, hills(700, 600)), folder / "cache");
  std::mt19937 random(12);
  const auto box = p->extent();
  std::uniform_real_distribution<double> x(box.min.x, box.max.x), y(box.min.y, box.max.y);
  for (int k = 0; k < 50; ++k) {
    const double x0 = x(random), y0 = y(random);
    const auto part = area(x0, y0, std::min(box.max.x, x0 + 60), std::min(box.max.y, y0 + 60));
    const auto bounds = p->bounds(0, part);
    ASSERT_TRUE(bounds);
    const auto w = p->window(0, part);
    std::uniform_real_distribution<double> u(part.min.x, part.max.x), v(part.min.y, part.max.y);
    for (int n = 0; n < 100; ++n) ASSERT_TRUE(bounds->contains(w.height(u(random), v(random))));
  }
  EXPECT_FALSE(p->bounds(0, area(-1e6, -1e6, -9e5, -9e5)));
}

TEST(Pyramid, ChunkDigestsChangeWithTheSamplesInReachAndNotBeyond) {
  const ScratchFolder folder;
  auto samples = hills(600, 600);
  const auto first = ingest(projected(folder, 600, 600, samples), folder / "cache");
  samples[0] += 10;  // north-west
  const auto second = ingest(projected(folder, 600, 600, samples), folder / "cache");
  const auto box = first->extent();
  const auto north_west = area(box.min.x, box.max.y - 50, box.min.x + 50, box.max.y);
  const auto south_east = area(box.max.x - 50, box.min.y, box.max.x, box.min.y + 50);
  EXPECT_NE(first->chunks(0, north_west), second->chunks(0, north_west));
  EXPECT_EQ(first->chunks(0, south_east), second->chunks(0, south_east));
  EXPECT_EQ(first->chunks(0, box).size(), 9u);
}

TEST(Pyramid, OfNoDataAloneIsEmpty) {
  const ScratchFolder folder;
  const auto p = ingest(projected(folder, 50, 50, std::vector<float>(2500, nan)), folder / "cache");
  EXPECT_TRUE(p->extent().empty());
  EXPECT_FALSE(p->bounds(0, Box::everywhere()));
  EXPECT_EQ(p->window(0, area(0, 0, 100, 100)).height(50, 50), 0);
}

TEST(Pyramid, ReadsRastersThatLieMirroredOrRotated) {
  const ScratchFolder folder;
  const auto samples = hills(60, 40);
  TiffOptions o;
  o.keys = utm();
  // Rows from the south, columns from the east.
  o.matrix = {-2, 0, 0, 500120, 0, 2, 0, 5000000, 0, 0, 0, 0, 0, 0, 0, 1};
  const auto mirrored = ingest(write_tiff(folder / "m.tif", 60, 40, samples, o), folder / "cache");
  const auto w = mirrored->window(0, mirrored->extent());
  const auto& level = mirrored->levels()[0];
  EXPECT_EQ(level.width, 60);
  EXPECT_EQ(w.height(level.x0 + 2 * 59.5, level.y0 + 1), static_cast<double>(samples[0]));
  EXPECT_EQ(w.height(level.x0 + 1, level.y0 + 2 * 39.5), static_cast<double>(samples[40 * 60 - 1]));

  // A quarter turn: columns go north, rows go east.
  o.matrix = {0, 2, 0, 500000, 2, 0, 0, 5000000, 0, 0, 0, 0, 0, 0, 0, 1};
  const auto turned = ingest(write_tiff(folder / "r.tif", 60, 40, samples, o), folder / "cache");
  EXPECT_EQ(turned->levels()[0].width, 40);
  EXPECT_EQ(turned->levels()[0].height, 60);
  const auto t = turned->window(0, turned->extent());
  EXPECT_NEAR(t.height(2 * 7.5, 2 * 5.5), static_cast<double>(samples[7 * 60 + 5]), 1e-4);
}

TEST(Pyramid, ConvertsHeightsInFeet) {
  const ScratchFolder folder;
  TiffOptions o;
  o.scale = {2, 2, 0};
  o.ties = {0, 0, 0, 500000, 5000000, 0};
  o.keys = [](GTIF* g) {
    utm()(g);
    GTIFKeySet(g, VerticalUnitsGeoKey, TYPE_SHORT, 1, 9002);
  };
  const auto p =
      ingest(write_tiff(folder / "feet.tif", 8, 8, std::vector<std::int16_t>(64, 1000), o),
             folder / "cache");
  EXPECT_NEAR(p->extent().max.z, 304.8, 1e-4);
}

TEST(Pyramid, LaysASecondRasterIntoTheFrameOfTheFirst) {
  const ScratchFolder folder;
  const auto first = geographic(folder, 100, 100, hills(100, 100));
  const auto frame = place(*Raster::open(first), {}).frame;
  TiffOptions o;
  o.scale = {25, 25, 0};
  o.ties = {0, 0, 0, 900000, 6500000, 0};
  o.keys = utm(2154);
  const auto far = write_tiff(folder / "second.tif", 50, 50, std::vector<float>(2500, 70.0f), o);
  const auto p = Pyramid::ingest(far, frame, 25, {}, folder / "cache");
  EXPECT_NEAR(p->extent().min.z, 70, 1e-4);
  EXPECT_EQ(p->levels()[0].x0, std::floor(p->levels()[0].x0 / 25) * 25);
  const auto local = write_tiff(folder / "local.tif", 50, 50, std::vector<float>(2500, 70.0f));
  EXPECT_THROW(Pyramid::ingest(local, frame, 25, {}, folder / "cache"), Error);
  EXPECT_THROW(Pyramid::ingest(far, Frame{}, 25, {}, folder / "cache"), Error);
}

TEST(Keys, SumsOfWeightsAreOneAndNeverLargerThanFiveQuartersInSize) {
  for (double f = 0; f < 1; f += 1.0 / 512) {
    const auto k = keys(f);
    double sum = 0, size = 0, slope = 0;
    for (int n = 0; n < 4; ++n) {
      sum += k.w[n];
      size += std::abs(k.w[n]);
      slope += k.d[n];
    }
    EXPECT_NEAR(sum, 1, 1e-15);
    EXPECT_NEAR(slope, 0, 1e-14);
    EXPECT_LE(size * size, keys_overshoot + 1e-12);
  }
}

}  // namespace
}  // namespace hoodoo::dem
