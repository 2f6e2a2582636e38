# The compiler cache, if there is one: what was compiled once is found again, with precompiled headers, and whether
# warnings are errors or not; what g++ compiled from any other clone, too (clang's precompiled headers know their folder).
find_program(FERRULE_CCACHE ccache)
if(FERRULE_CCACHE AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  get_filename_component(source ${CMAKE_CURRENT_LIST_DIR} DIRECTORY)
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${source}
    CCACHE_NOHASHDIR=1
    CCACHE_IGNOREOPTIONS=-Werror
    CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime)
  if(CMAKE_CXX_CLANG_TIDY)
    # The cache has clang-tidy read what it compiles: what was clean is not read again. It knows the rules by the names of
    # namespace and file, and comments count, as NOLINT is one.
    list(JOIN CMAKE_CXX_CLANG_TIDY " " tidy)
    list(APPEND CMAKE_CXX_COMPILER_LAUNCHER "FERRULE_CLANG_TIDY=${tidy}" "CCACHE_NAMESPACE=${tidy}" CCACHE_COMMENTS=1
      CCACHE_EXTRAFILES=${source}/.clang-tidy CCACHE_PREFIX=${CMAKE_CURRENT_LIST_DIR}/tidied)
    set(CMAKE_CXX_CLANG_TIDY "")
  endif()
  if(EMSCRIPTEN)
    list(APPEND CMAKE_CXX_COMPILER_LAUNCHER CCACHE_COMPILERTYPE=clang) # which it calls
  endif()
  list(APPEND CMAKE_CXX_COMPILER_LAUNCHER ${FERRULE_CCACHE})
  if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    add_compile_options(-fpch-preprocess)
  elseif(CMAKE_CXX_COMPILER_ID MATCHES Clang)
    add_compile_options("SHELL:-Xclang -fno-pch-timestamp")
  endif()
endif()

# What a folder adds from here on is not read by clang-tidy.
macro(ferrule_untidied)
  set(CMAKE_CXX_CLANG_TIDY "")
  list(FILTER CMAKE_CXX_COMPILER_LAUNCHER EXCLUDE REGEX "^(FERRULE_CLANG_TIDY|CCACHE_(NAMESPACE|COMMENTS|EXTRAFILES|PREFIX))=")
endmacro()
