#include "engine/dem/georeference.hpp"

#include <fmt/format.h>
#include <geo_normalize.h>
#include <geotiff.h>
#include <geotiffio.h>
#include <geovalues.h>
#include <xtiffio.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "engine/dem/crs.hpp"

namespace hoodoo::dem {
namespace {

struct Free {
  void operator()(GTIF* keys) const { GTIFFree(keys); }
};
using Keys = std::unique_ptr<GTIF, Free>;

void say_nothing(GTIF*, int, const char*, ...) {}

std::span<const double> doubles(TIFF* tiff, std::uint32_t tag) {
  std::uint16_t count = 0;
  double* values = nullptr;
  if (!TIFFGetField(tiff, tag, &count, &values) || !values) return {};
  return {values, count};
}

int short_key(GTIF* keys, geokey_t key, int fallback) {
  unsigned short value = 0;
  return keys && GTIFKeyGetSHORT(keys, key, &value, 0, 1) == 1 ? value : fallback;
}

std::string text_key(GTIF* keys, geokey_t key) {
  int size = 0;
  tagtype_t type = TYPE_UNKNOWN;
  const int length = GTIFKeyInfo(keys, key, &size, &type);
  if (length < 1 || length > 65536 || type != TYPE_ASCII) return {};
  std::string text(static_cast<std::size_t>(length) + 1, '\0');
  if (GTIFKeyGetASCII(keys, key, text.data(), length) < 1) return {};
  text.resize(text.find('\0'));
  return text;
}

// The order of preference is GDAL's: scale and tiepoint, else the matrix.
std::array<double, 6> read_transform(const TiffFile& file) {
  const auto scale = doubles(file.get(), TIFFTAG_GEOPIXELSCALE);
  const auto ties = doubles(file.get(), TIFFTAG_GEOTIEPOINTS);
  const auto matrix = doubles(file.get(), TIFFTAG_GEOTRANSMATRIX);
  if (scale.size() >= 2 && scale[0] != 0 && scale[1] != 0 && ties.size() >= 6) {
    // Rows go south whatever the sign of the scale: files with a negative one exist, and every
    // reader takes them so.
    const double dx = scale[0], dy = -std::abs(scale[1]);
    return {ties[3] - ties[0] * dx, dx, 0, ties[4] - ties[1] * dy, 0, dy};
  }
  if (matrix.size() == 16) {
    return {matrix[3], matrix[0], matrix[1], matrix[7], matrix[4], matrix[5]};
  }
  if (ties.size() >= 12) {
    throw file.error(
        Fault::bad_input,
        fmt::format("is placed by {} ground control points; it must be rectified first",
                    ties.size() / 6));
  }
  return RasterInfo{}.transform;
}

void check_transform(const TiffFile& file, const RasterInfo& info) {
  const auto& t = info.transform;
  const double determinant = t[1] * t[5] - t[2] * t[4];
  const double across = std::sqrt(t[1] * t[1] + t[4] * t[4]);
  const double down = std::sqrt(t[2] * t[2] + t[5] * t[5]);
  bool good = std::abs(determinant) > 1e-6 * across * down;
  for (const double value : t) good = good && std::abs(value) <= 1e10;
  good = good && across >= 1e-9 && down >= 1e-9;
  // Beyond 2^45 pixels from the CRS's origin a double no longer tells pixels apart well.
  good = good && std::abs(t[0]) <= 1e12 * across && std::abs(t[3]) <= 1e12 * down;
  if (!good) {
    throw file.error(
        Fault::bad_input,
        fmt::format("has a pixel-to-map transform that cannot be used: x = {} + {} i + "
                    "{} j, y = {} + {} i + {} j",
                    t[0], t[1], t[2], t[3], t[4], t[5]));
  }
}

std::optional<double> parse_nodata(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '+')) text.remove_prefix(1);
  double value = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status == std::errc::result_out_of_range) {
    return text.front() == '-' ? -std::numeric_limits<double>::infinity()
                               : std::numeric_limits<double>::infinity();
  }
  if (status != std::errc{}) return std::nullopt;
  // Windows wrote NaN and infinity as "1.#QNAN" and "-1.#INF"; either is no elevation.
  const bool windows_nan = end != text.data() + text.size() && *end == '#';
  return windows_nan ? std::numeric_limits<double>::quiet_NaN() : value;
}

std::optional<double> read_nodata(TIFF* tiff) {
  constexpr std::uint32_t tag = 42113;
  const TIFFField* const known = TIFFFindField(tiff, tag, TIFF_ANY);
  char* text = nullptr;
  if (!known || TIFFFieldPassCount(known) || !TIFFGetField(tiff, tag, &text) || !text) {
    return std::nullopt;
  }
  return parse_nodata(text);
}

std::string as_wkt(const ProjContext& context, const std::string& definition) {
  const PjPointer crs(proj_create(context.get(), definition.c_str()));
  const char* const one_line[] = {"MULTILINE=NO", nullptr};
  const char* const text =
      crs ? proj_as_wkt(context.get(), crs.get(), PJ_WKT2_2019, one_line) : nullptr;
  return text ? text : "";
}

struct Found {
  std::string crs;
  CrsFacts facts;
  bool by_parameters = false;
};

std::optional<Found> by_code(const ProjContext& context, int code) {
  for (const char* authority : {"EPSG", "ESRI"}) {
    auto name = fmt::format("{}:{}", authority, code);
    if (auto facts = describe(context, name)) return Found{std::move(name), *facts, false};
  }
  return std::nullopt;
}

std::optional<Found> by_parameters(const ProjContext& context, GTIF* keys, GTIFDefn* definition) {
  constexpr std::string_view esri = "ESRI PE String = ";
  for (const geokey_t key : {PCSCitationGeoKey, GTCitationGeoKey, GeogCitationGeoKey}) {
    const auto text = text_key(keys, key);
    if (text.rfind(esri, 0) != 0) continue;
    auto wkt = as_wkt(context, text.substr(esri.size()));
    if (auto facts = describe(context, wkt)) return Found{std::move(wkt), *facts, false};
  }
  const std::unique_ptr<char, decltype(&GTIFFreeMemory)> text(GTIFGetProj4Defn(definition),
                                                              &GTIFFreeMemory);
  if (!text) return std::nullopt;
  auto wkt = as_wkt(context, std::string(text.get()) + " +no_defs +type=crs");
  if (auto facts = describe(context, wkt)) return Found{std::move(wkt), *facts, true};
  return std::nullopt;
}

// Coordinates of the file in the units of the CRS as PROJ has it: files may override the unit.
void convert_units(const GTIFDefn& definition, const Found& found, RasterInfo& info) {
  double factor = 1;
  if (found.facts.kind == RasterInfo::Crs::geographic) {
    // The parameters went to PROJ as degrees.
    if (found.by_parameters) factor = definition.UOMAngleInDegrees;
  } else {
    factor = definition.UOMLengthInMeters / found.facts.unit;
  }
  // Both give the survey foot by a fraction of their own.
  if (!(factor > 0) || !std::isfinite(factor) || std::abs(factor - 1) < 1e-9) return;
  for (double& value : info.transform) value *= factor;
}

double unit_of_heights(GTIF* keys, const ProjContext& context) {
  const int code = short_key(keys, VerticalUnitsGeoKey, 0);
  double metres = 1;
  if (code == 0 || code == KvUserDefined ||
      !GTIFGetUOMLengthInfoEx(context.get(), code, nullptr, &metres)) {
    return 1;
  }
  return metres > 0 && std::isfinite(metres) ? metres : 1;
}

/// Codes 5001 to 5035 are the ellipsoids of GeoTIFF 1.0 (its section 6.3.4.1); others are EPSG's.
std::string heights_of(GTIF* keys) {
  const int code = short_key(keys, VerticalCSTypeGeoKey, 0);
  if (code >= 5001 && code <= 5035) return "ellipsoid";
  return code > 0 && code < KvUserDefined ? fmt::format("EPSG:{}", code) : "";
}

void read_crs(const TiffFile& file, GTIF* keys, const ProjContext& context, RasterInfo& info) {
  GTIFDefn definition{};
  if (!GTIFGetDefn(keys, &definition) || !definition.DefnSet) return;
  const int pcs = static_cast<std::uint16_t>(definition.PCS);
  const int gcs = static_cast<std::uint16_t>(definition.GCS);
  const int model = static_cast<std::uint16_t>(definition.Model);
  const auto stated = [](int code) { return code != 0 && code != KvUserDefined; };
  if (model == ModelTypeGeocentric) {
    throw file.error(Fault::bad_input,
                     "has geocentric coordinates, which no raster can be laid on");
  }
  const bool projected =
      model == ModelTypeProjected || (model != ModelTypeGeographic && stated(pcs));
  if (!projected && model != ModelTypeGeographic && !stated(gcs)) return;  // keys, but no CRS
  const int code = projected ? pcs : gcs;
  auto found = stated(code) ? by_code(context, code) : std::nullopt;
  if (!found) found = by_parameters(context, keys, &definition);
  const bool plane = found && found->facts.kind != RasterInfo::Crs::geographic;
  if (!found || plane != projected) {
    throw file.error(Fault::bad_input,
                     fmt::format("states a {} coordinate system (code {}) that PROJ cannot use",
                                 projected ? "projected" : "geographic", code));
  }
  info.crs = found->crs;
  info.kind = found->facts.kind;
  info.crs_name = found->facts.name;
  info.unit = found->facts.unit;
  convert_units(definition, *found, info);
}

}  // namespace

void read_georeference(const TiffFile& file, RasterInfo& info) {
  info.nodata = read_nodata(file.get());
  info.transform = read_transform(file);
  const ProjContext context;
  const Keys keys(GTIFNewEx(file.get(), say_nothing, nullptr));
  if (keys) {
    GTIFAttachPROJContext(keys.get(), context.get());
    info.pixel_is_point =
        short_key(keys.get(), GTRasterTypeGeoKey, RasterPixelIsArea) == RasterPixelIsPoint;
    info.vertical_unit = unit_of_heights(keys.get(), context);
    info.vertical = heights_of(keys.get());
    read_crs(file, keys.get(), context, info);
  }
  auto& t = info.transform;
  if (info.pixel_is_point) {
    // The tiepoint stands for the centre of its pixel.
    t[0] -= 0.5 * (t[1] + t[2]);
    t[3] -= 0.5 * (t[4] + t[5]);
  }
  check_transform(file, info);
}

}  // namespace hoodoo::dem
