// Gives every file below the folders of the command line to a fuzz target, once.
#include <cstdint>
#include <filesystem>
#include <iostream>

#include "engine/base/file.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

int main(int argc, char** argv) {
  std::size_t files = 0;
  for (int i = 1; i < argc; ++i) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(argv[i])) {
      if (!entry.is_regular_file()) continue;
      const auto text = hoodoo::read_file(entry.path(), 1U << 26);
      std::cout << entry.path().string() << std::endl;  // before, in case it is the last
      LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(text.data()), text.size());
      ++files;
    }
  }
  std::cout << files << " inputs\n";
  return files > 0 ? 0 : 1;
}
