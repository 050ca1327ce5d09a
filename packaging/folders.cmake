# Where things are installed.  As GNU has it; but where the system keeps libraries in a folder for each architecture, as
# Debian does, ours are there too, whatever the prefix: packages are staged below /usr, which is not the prefix that a
# build is configured with, and compilers, CMake and pkg-config look there below /usr/local as well.
if(NOT DEFINED CMAKE_INSTALL_LIBDIR AND CMAKE_LIBRARY_ARCHITECTURE AND EXISTS /etc/debian_version)
  set(CMAKE_INSTALL_LIBDIR lib/${CMAKE_LIBRARY_ARCHITECTURE} CACHE PATH "Libraries, below the prefix")
endif()
include(GNUInstallDirs)
