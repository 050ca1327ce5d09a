# Debian packages: qs-tools, qs-view where it is built, libqs-tools-dev.  What programs need is found by dpkg-shlibdeps;
# OpenGL is not among it, it is loaded at run time by those who ask for it.

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME qs-tools)
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "")  # each package has its own
set(CPACK_PACKAGE_CONTACT "qs-tools developers <qs-tools@example.org>")
set(CPACK_STRIP_FILES ON)
# Units are told where the programs will be, which is not where they are staged.
set(CPACK_SET_DESTDIR ON)
set(CPACK_INSTALL_PREFIX /usr)
set(CPACK_PRE_BUILD_SCRIPTS ${QS_PACKAGE_SOURCE}/debian-staged.cmake)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)

# What is in `component` is package `name`; licence and history go with each.
macro(qs_debian_package component name section summary)
  list(APPEND CPACK_COMPONENTS_ALL ${component})
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${name})
  set(CPACK_DEBIAN_${upper}_PACKAGE_SECTION ${section})
  set(CPACK_COMPONENT_${upper}_DESCRIPTION "${summary}")
  install(FILES LICENSE RENAME copyright DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
  install(FILES CHANGELOG.md RENAME changelog DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name} COMPONENT ${component})
endmacro()

set(CPACK_COMPONENTS_ALL)
qs_debian_package(tools qs-tools graphics
  "multiresolution models of huge scans: build, stream, draw
Programs that turn a huge scan, a mesh or a cloud of points, into a
multiresolution model, draw it without a display, and stream it over ordinary
networks, with a bound on the error of every frame.")
set(CPACK_DEBIAN_TOOLS_PACKAGE_SUGGESTS "libegl1, libosmesa6, ffmpeg")
if(TARGET qs-view)
  qs_debian_package(viewer qs-view graphics
    "viewer of the models of qs-tools
A window on multiresolution models of huge scans, from files or while they
arrive over a network.")
  set(CPACK_DEBIAN_VIEWER_PACKAGE_RECOMMENDS "qs-tools, libgl1")
endif()
qs_debian_package(development libqs-tools-dev libdevel
  "multiresolution models of huge scans: static libraries and headers
The libraries that the programs of qs-tools are made of, with a file for
pkg-config and a package for CMake.")
set(development libhwy-dev libxxhash-dev libzstd-dev libdeflate-dev libpng-dev libtbb-dev libglm-dev libcli11-dev
                nlohmann-json3-dev)
if(QS_FETCH)
  list(APPEND development libcurl4-openssl-dev)
endif()
if(QS_DRACO)
  list(APPEND development libdraco-dev)
endif()
if(QS_EMBREE)
  list(APPEND development libembree-dev)
endif()
list(JOIN development ", " CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS)

include(CPack)
