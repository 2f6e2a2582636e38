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
  set_target_properties(${target} PROPERTIES EXPORT_NAME ${name} POSITION_INDEPENDENT_CODE ON)
  target_include_directories(${target} PUBLIC
    $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}> $<INSTALL_INTERFACE:include/ferrule>)
  target_compile_features(${target} PUBLIC cxx_std_20)
  ferrule_warnings(${target})
  if(FERRULE_SANITIZE) # what the tests call for long; they themselves compile faster without
    target_compile_options(${target} PRIVATE -O2)
  endif()
  target_link_libraries(${target} PUBLIC ${ARG_LINKS} PRIVATE ${ARG_PRIVATE_LINKS})
endfunction()

# Warnings are errors; results must not depend on how the compiler contracts products and sums.
function(ferrule_warnings target)
  target_compile_options(${target} PRIVATE
    -Wall -Wextra -Wpedantic -Wshadow -Werror -ffp-contract=off)
endfunction()
