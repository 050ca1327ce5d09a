# What is installed, and in which of the packages it is: `tools`, the programs, which need no display; `viewer`, the
# program that opens windows, and what that needs; `development`, the libraries and their headers.
#
#     cmake --install build --prefix ~/.local                      all of it
#     cpack --config build/CPackConfig.cmake -B build/packages     Debian packages

include(CMakePackageConfigHelpers)
set(QS_PACKAGE_SOURCE ${CMAKE_CURRENT_LIST_DIR})
set(QS_INCLUDE_DIR ${CMAKE_INSTALL_INCLUDEDIR}/qs-tools)
set(QS_CMAKE_DIR ${CMAKE_INSTALL_LIBDIR}/cmake/qs-tools)

# qs-tools::<folder>, with its headers: lib/splat/model.h is #include "splat/model.h".  What is compiled once for each
# set of instructions, *-inl.h, is nobody else's.
function(qs_install_library folder)
  set_target_properties(qs_${folder} PROPERTIES EXPORT_NAME ${folder})
  install(TARGETS qs_${folder} EXPORT qs-tools-targets ARCHIVE COMPONENT development)
  install(DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR}/ DESTINATION ${QS_INCLUDE_DIR}/${folder} COMPONENT development
          FILES_MATCHING PATTERN "*.h" PATTERN "*-inl.h" EXCLUDE)
  set_property(GLOBAL APPEND PROPERTY QS_LIBRARIES ${folder})
endfunction()

function(qs_install_page page component)
  get_filename_component(section ${page} LAST_EXT)
  string(SUBSTRING ${section} 1 -1 section)
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man${section} COMPONENT ${component})
endfunction()

function(qs_install_pages)
  foreach(page ${ARGN})
    qs_install_page(${page} tools)
  endforeach()
endfunction()

# A program, its page, and its completions, which the program itself writes; for the tools, if no component is said.
function(qs_install_program name)
  set(component tools ${ARGN})
  list(GET component -1 component)
  install(TARGETS ${name} COMPONENT ${component})
  qs_install_page(man/${name}.1 ${component})
  qs_completion(bash ${name} bash-completion/completions)
  qs_completion(zsh _${name} zsh/site-functions)
  qs_completion(fish ${name}.fish fish/vendor_completions.d)
endfunction()

# For program `name` and install component `component`, as the function above has them.  Each shell finds a completion by
# the name of its file.
macro(qs_completion shell file folder)
  set(script ${CMAKE_BINARY_DIR}/share/${folder}/${file})
  file(MAKE_DIRECTORY ${CMAKE_BINARY_DIR}/share/${folder})
  add_custom_command(TARGET ${name} POST_BUILD VERBATIM
    COMMAND sh -c "\"$1\" --completion \"$2\" > \"$3\"" - $<TARGET_FILE:${name}> ${shell} ${script})
  install(FILES ${script} DESTINATION ${CMAKE_INSTALL_DATADIR}/${folder} COMPONENT ${component})
endmacro()

# Units of share/systemd for `manager`, user or system.  NAME.in is completed when it is installed, for the programs may
# be anywhere: @BINDIR@ is their folder, @HARDENED@ what all servers are kept from.
function(qs_install_units manager)
  set(folder lib/systemd/${manager})
  foreach(unit ${ARGN})
    set(source ${CMAKE_SOURCE_DIR}/share/systemd/${unit})
    if(NOT EXISTS ${source}.in)
      install(FILES ${source} DESTINATION ${folder} COMPONENT tools)
      continue()
    endif()
    install(CODE "
      set(BINDIR \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_BINDIR}\")
      file(READ \"${CMAKE_SOURCE_DIR}/share/systemd/hardened.conf\" HARDENED)
      configure_file(\"${source}.in\" \"${CMAKE_BINARY_DIR}/share/systemd/${unit}\" @ONLY)
      file(INSTALL \"${CMAKE_BINARY_DIR}/share/systemd/${unit}\" DESTINATION \"\${CMAKE_INSTALL_PREFIX}/${folder}\")"
      COMPONENT tools)
  endforeach()
endfunction()

# What finds the libraries: a CMake package and qs-tools.pc.  What they need of others is in both.
function(qs_install_finders)
  set_target_properties(qs_options PROPERTIES EXPORT_NAME options)
  install(TARGETS qs_options EXPORT qs-tools-targets)
  install(EXPORT qs-tools-targets NAMESPACE qs-tools:: DESTINATION ${QS_CMAKE_DIR} COMPONENT development)
  configure_package_config_file(${QS_PACKAGE_SOURCE}/qs-tools-config.cmake.in
    ${CMAKE_BINARY_DIR}/packaging/qs-tools-config.cmake INSTALL_DESTINATION ${QS_CMAKE_DIR})
  write_basic_package_version_file(${CMAKE_BINARY_DIR}/packaging/qs-tools-config-version.cmake
    COMPATIBILITY SameMinorVersion)
  install(FILES ${CMAKE_BINARY_DIR}/packaging/qs-tools-config.cmake
                ${CMAKE_BINARY_DIR}/packaging/qs-tools-config-version.cmake
          DESTINATION ${QS_CMAKE_DIR} COMPONENT development)

  # A static library stands before those that it needs.
  get_property(libraries GLOBAL PROPERTY QS_LIBRARIES)
  list(REVERSE libraries)
  list(TRANSFORM libraries PREPEND -lqs_)
  list(JOIN libraries " " PC_LIBRARIES)
  set(requires libhwy libxxhash libzstd libdeflate libpng tbb glm CLI11 nlohmann_json)
  if(QS_FETCH)
    list(APPEND requires libcurl)
  endif()
  if(QS_DRACO)
    list(APPEND requires draco)
  endif()
  list(JOIN requires ", " PC_REQUIRES)
  list(TRANSFORM CMAKE_DL_LIBS PREPEND -l OUTPUT_VARIABLE PC_OTHERS)
  string(PREPEND PC_OTHERS "-pthread ")
  if(QS_EMBREE)
    string(APPEND PC_OTHERS " -lembree3")  # it has no file of its own
  endif()
  string(REGEX REPLACE "[^/]+" ".." PC_PREFIX ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  configure_file(${QS_PACKAGE_SOURCE}/qs-tools.pc.in ${CMAKE_BINARY_DIR}/packaging/qs-tools.pc @ONLY)
  install(FILES ${CMAKE_BINARY_DIR}/packaging/qs-tools.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT development)
endfunction()

# After all programs and libraries.
macro(qs_install_packages)
  qs_install_finders()
  install(FILES README.md DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT tools)
  install(DIRECTORY examples/library DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libqs-tools-dev/examples
          COMPONENT development)
  include(${QS_PACKAGE_SOURCE}/debian.cmake)
endmacro()
