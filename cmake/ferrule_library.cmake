# ferrule_library(NAME LINKS ... [PRIVATE_LINKS ...] [WITHOUT FILE...])
# One static library per folder, of all its sources but those WITHOUT: target ferrule_NAME, alias and installed name ferrule::NAME.
function(ferrule_library name)
  cmake_parse_arguments(ARG "" "" "LINKS;PRIVATE_LINKS;WITHOUT" ${ARGN})
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} *.cpp)
  if(ARG_WITHOUT)
    list(REMOVE_ITEM sources ${ARG_WITHOUT})
  endif()
  set(target ferrule_${name})
  add_library(${target} STATIC ${sources})
  add_library(ferrule::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/ferrule>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  ferrule_library_options(${target})
  target_link_libraries(${target} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
  target_precompile_headers(${target} REUSE_FROM ferrule_precompiled)
endfunction()

# ferrule_loaded_library(NAME SOURCE [COMPONENT]): a part of the program that it loads when first needed
# (learn/loaded_library.hpp), because of what it links or how long it compiles; without a component it is not installed.
set(FERRULE_LOADED ${PROJECT_BINARY_DIR}/loaded)
function(ferrule_loaded_library name source)
  set(target ferrule_${name})
  add_library(${target} MODULE ${source})
  set_target_properties(${target} PROPERTIES PREFIX "" LIBRARY_OUTPUT_DIRECTORY ${FERRULE_LOADED})
  ferrule_warnings(${target})
  target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
  if(ARGN)
    install(TARGETS ${target} LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/ferrule COMPONENT ${ARGN})
  endif()
endfunction()

# ferrule_text(TARGET NAME TEXT): the text as `extern const std::string_view NAME` of a source of the target.
function(ferrule_text target name text)
  file(CONFIGURE OUTPUT ${name}.cpp @ONLY CONTENT [[
#include <string_view>

namespace ferrule {
extern const std::string_view @name@;
const std::string_view @name@ = R"text(@text@)text";
}  // namespace ferrule
]])
  target_sources(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR}/${name}.cpp)
endfunction()

# The same for all libraries, or they could not share precompiled headers.
function(ferrule_library_options target)
  set_target_properties(${target} PROPERTIES POSITION_INDEPENDENT_CODE ON)
  ferrule_warnings(${target})
  target_compile_definitions(${target} PRIVATE
    $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
  if(FERRULE_SANITIZE) # what the tests call for long; they themselves compile faster without
    target_compile_options(${target} PRIVATE -O2)
  endif()
endfunction()

# Results must not depend on how the compiler contracts products and sums; nobody looks at errno or
# at the exceptions of floating point, which would only cost time. gcc 12 sees ghosts in std::string
# (its bug 105329).
function(ferrule_warnings target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -ffp-contract=off -fno-math-errno -fno-trapping-math
    "$<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-restrict;-Wno-stringop-overflow;-Wno-stringop-overread>"
    $<$<BOOL:${FERRULE_WERROR}>:-Werror>)
endfunction()

# What most files include and what takes longest to read. Every file still includes what it uses
# (clang-tidy reads them without this).
set(FERRULE_PRECOMPILED <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <iostream>
  <limits> <map> <memory> <numbers> <optional> <set> <sstream> <string> <vector> <Eigen/Cholesky>
  <Eigen/Core> <Eigen/Eigenvalues> <Eigen/LU> <nlohmann/json.hpp> <fmt/format.h>)

# ferrule_precompile(TARGET HEADER...): those, and more.
function(ferrule_precompile target)
  target_precompile_headers(${target} PRIVATE ${FERRULE_PRECOMPILED} ${ARGN})
endfunction()

function(ferrule_precompiled_for_libraries)
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/precompiled.cpp CONTENT "")
  add_library(ferrule_precompiled OBJECT ${PROJECT_BINARY_DIR}/precompiled.cpp)
  target_link_libraries(ferrule_precompiled PRIVATE Eigen3::Eigen nlohmann_json::nlohmann_json fmt::fmt)
  ferrule_library_options(ferrule_precompiled)
  ferrule_precompile(ferrule_precompiled)
endfunction()
