#include "tiling/tileset/content.hpp"

#include "tiling/glb/slabs.hpp"
#include "tiling/store/store.hpp"

namespace hoodoo::tileset {

glb::Decoded read_tile(const std::filesystem::path& folder, const Record& record, double step,
                       glb::Wanted wanted) {
  std::vector<glb::Decoded> slabs;
  for (const auto& file : record.files()) {
    const auto where = (folder / store::tile_path(file.content)).string();
    slabs.push_back(glb::read(store::get_tile(folder, file.content), step, where, wanted));
  }
  return glb::join(std::move(slabs));
}

}  // namespace hoodoo::tileset
