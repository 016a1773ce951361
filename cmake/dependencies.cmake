# Every third-party library, as a target. All are Debian 12 packages but the cpp-httplib header, which
# deploy/setup.sh takes from the source package of a newer suite.

find_package(Threads REQUIRED)
find_package(CLI11 REQUIRED)
find_package(CURL 7.85 REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
find_package(PROJ REQUIRED CONFIG)
find_package(SQLite3 REQUIRED)
find_package(TBB REQUIRED CONFIG)
find_package(TIFF REQUIRED)
find_package(ZLIB REQUIRED)
find_package(draco REQUIRED CONFIG)
find_package(fmt REQUIRED CONFIG)
find_package(hwy REQUIRED CONFIG)
find_package(meshoptimizer REQUIRED CONFIG)
find_package(nanoflann REQUIRED CONFIG)
find_package(nlohmann_json 3.11 REQUIRED CONFIG)
find_package(prometheus-cpp REQUIRED CONFIG)
find_package(spdlog REQUIRED CONFIG)

# Debian's OpenImageIO target lists an OpenCV include folder that its package does not bring.
find_package(OpenImageIO REQUIRED CONFIG)
set_target_properties(OpenImageIO::OpenImageIO PROPERTIES
  INTERFACE_INCLUDE_DIRECTORIES "${OpenImageIO_INCLUDE_DIR}")

# libgeotiff has no CMake package.
find_library(GEOTIFF_LIBRARY geotiff REQUIRED)
find_path(GEOTIFF_INCLUDE_DIR geotiff.h PATH_SUFFIXES geotiff REQUIRED)
add_library(hoodoo_geotiff INTERFACE)
target_include_directories(hoodoo_geotiff SYSTEM INTERFACE ${GEOTIFF_INCLUDE_DIR})
target_link_libraries(hoodoo_geotiff INTERFACE ${GEOTIFF_LIBRARY} TIFF::TIFF PROJ::proj)

# Nor have these two.
find_library(BROTLI_LIBRARY brotlienc REQUIRED)
find_library(ZSTD_LIBRARY zstd REQUIRED)
add_library(hoodoo_brotli INTERFACE)
target_link_libraries(hoodoo_brotli INTERFACE ${BROTLI_LIBRARY})
add_library(hoodoo_zstd INTERFACE)
target_link_libraries(hoodoo_zstd INTERFACE ${ZSTD_LIBRARY})

# Debian's package has a CMake module only, whose folder brings a FindTBB.cmake of its own. The headers want
# Boost's; their half-precision numbers are Imath's. Files are packed by zlib or Blosc.
find_library(OPENVDB_LIBRARY openvdb REQUIRED)
find_library(BLOSC_LIBRARY blosc REQUIRED)
find_library(IMATH_LIBRARY Imath REQUIRED)
find_path(OPENVDB_INCLUDE_DIR openvdb/openvdb.h REQUIRED)
add_library(hoodoo_openvdb INTERFACE)
target_include_directories(hoodoo_openvdb SYSTEM INTERFACE ${OPENVDB_INCLUDE_DIR})
target_link_libraries(hoodoo_openvdb INTERFACE ${OPENVDB_LIBRARY} ${IMATH_LIBRARY} ${BLOSC_LIBRARY}
  TBB::tbb ZLIB::ZLIB)

# Header only: Debian's libtinygltf is built without Draco, and libdraco exports symbols of its own copy.
find_path(TINYGLTF_INCLUDE_DIR tiny_gltf.h REQUIRED)
add_library(hoodoo_tinygltf INTERFACE)
target_include_directories(hoodoo_tinygltf SYSTEM INTERFACE ${TINYGLTF_INCLUDE_DIR})

# cpp-httplib before 0.41 has known holes (request smuggling, unbounded memory).
set(HTTPLIB_MINIMUM 0.41.0)
find_path(HTTPLIB_INCLUDE_DIR httplib.h PATHS /usr/local/include/cpp-httplib NO_DEFAULT_PATH)
if(NOT HTTPLIB_INCLUDE_DIR)
  message(FATAL_ERROR "The cpp-httplib header is missing. Run deploy/setup.sh first.")
endif()
file(STRINGS ${HTTPLIB_INCLUDE_DIR}/httplib.h httplib_version
  REGEX "^#define CPPHTTPLIB_VERSION \"[0-9.]+\"")
string(REGEX REPLACE ".*\"([0-9.]+)\".*" "\\1" httplib_version "${httplib_version}")
if(NOT httplib_version VERSION_GREATER_EQUAL HTTPLIB_MINIMUM)
  message(FATAL_ERROR "cpp-httplib ${httplib_version} is older than ${HTTPLIB_MINIMUM}. "
                      "Run deploy/setup.sh to replace it.")
endif()
add_library(hoodoo_httplib INTERFACE)
target_include_directories(hoodoo_httplib SYSTEM INTERFACE ${HTTPLIB_INCLUDE_DIR})
# A connection that waits looks twice a second, not a hundred times, whether the server stops: thousands may wait.
target_compile_definitions(hoodoo_httplib INTERFACE CPPHTTPLIB_LISTEN_BACKLOG=4096
  CPPHTTPLIB_KEEPALIVE_TIMEOUT_CHECK_INTERVAL_USECOND=500000)
target_link_libraries(hoodoo_httplib INTERFACE Threads::Threads)
