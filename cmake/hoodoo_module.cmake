# Warnings and arithmetic of our own code. Third-party headers are system includes.
function(hoodoo_compile_options target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Wconversion -ffp-contract=off
    # g++ 12 sees overlaps in std::string that are not there (its bug 105651).
    $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>
    # Its vectoriser of straight-line code leaves out the rounding in two neighbouring
    # double(float(x)), which bounds that hold what single precision gives rely on.
    $<$<CXX_COMPILER_ID:GNU>:-fno-tree-slp-vectorize>)
  target_compile_features(${target} PRIVATE cxx_std_20)
  set_target_properties(${target} PROPERTIES CXX_EXTENSIONS OFF)
endfunction()

# hoodoo_module(<name> [HEADERS ..] [SOURCES ..] [USES ..] [PRIVATE ..])
#
# One folder, one library hoodoo::<name>, one namespace. Paths are relative to the folder. USES and
# PRIVATE name third-party targets and modules declared above; PRIVATE is what no header mentions.
function(hoodoo_module name)
  cmake_parse_arguments(ARG "" "" "HEADERS;SOURCES;USES;PRIVATE" ${ARGN})
  if(ARG_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "hoodoo_module(${name}): unexpected ${ARG_UNPARSED_ARGUMENTS}")
  endif()
  foreach(used IN LISTS ARG_USES ARG_PRIVATE)
    if(NOT TARGET ${used})
      message(FATAL_ERROR "${name} uses ${used}, which is not declared above it")
    endif()
  endforeach()
  if(ARG_SOURCES)
    set(kind PUBLIC)
    add_library(hoodoo_${name} STATIC ${ARG_SOURCES})
    hoodoo_compile_options(hoodoo_${name})
    target_link_libraries(hoodoo_${name} PRIVATE ${ARG_PRIVATE})
  else()
    set(kind INTERFACE)
    add_library(hoodoo_${name} INTERFACE)
  endif()
  add_library(hoodoo::${name} ALIAS hoodoo_${name})
  target_sources(hoodoo_${name} ${kind} FILE_SET HEADERS
    BASE_DIRS ${PROJECT_SOURCE_DIR} FILES ${ARG_HEADERS})
  target_compile_features(hoodoo_${name} ${kind} cxx_std_20)
  target_link_libraries(hoodoo_${name} ${kind} ${ARG_USES})
  # The target all_verify_interface_header_sets compiles every header alone.
  set_target_properties(hoodoo_${name} PROPERTIES VERIFY_INTERFACE_HEADER_SETS ON)
endfunction()
