// The one implementation of tinygltf. Debian's library is built without Draco, and libdraco exports
// symbols of a copy of its own, so neither is linked for it.
#define TINYGLTF_IMPLEMENTATION
#include "tiling/glb/tinygltf.hpp"
