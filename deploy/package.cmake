# The Debian package: deploy/package.sh, or cpack -G DEB in build/release. What only a package has
# (configuration, unit, changelogs, compression) is laid out by debian/stage.cmake.
set(FREELSD_MAINTAINER "the freelsd authors <freelsd@freelsd.invalid>"
    CACHE STRING "Maintainer field of the Debian package")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME freelsd)
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_CONTACT "${FREELSD_MAINTAINER}")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "landing sites for small planes, from photographs")
set(CPACK_PACKAGE_DESCRIPTION
"Finds places to land in country nobody has mapped: images, poses and wind of a
small plane go in over HTTP; ranked sites with touchdown point, hazard map and
an approach path into the wind come out, and are kept on disk.
.
The package holds the service, its page for the ground station, freelsdctl,
which sends photographs and shows what was found, and freelsd-mavlink, which
links the service to an autopilot. It needs no GPU and no network.")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
    OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)

set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_PACKAGE_PRIORITY optional)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# freelsdctl calls curl and jq; freelsd-mavlink runs in Node.
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "curl, jq, nodejs (>= 18)")
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION TRUE)
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
    ${PROJECT_SOURCE_DIR}/deploy/debian/conffiles
    ${PROJECT_SOURCE_DIR}/deploy/debian/postinst
    ${PROJECT_SOURCE_DIR}/deploy/debian/prerm
    ${PROJECT_SOURCE_DIR}/deploy/debian/postrm)
# Libraries of the other processor are not installed here, but lie in its folder; deploy/arm64/register_packages.sh
# wrote down their packages.
if(CMAKE_CROSSCOMPILING)
  set(CPACK_DEBIAN_PACKAGE_ARCHITECTURE arm64)
  set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS
      ${CMAKE_SYSROOT}/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE} ${CMAKE_SYSROOT}/lib/${CMAKE_LIBRARY_ARCHITECTURE})
endif()
set(CPACK_FREELSD_STRIP ${CMAKE_STRIP})
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/deploy/debian/stage.cmake)
include(CPack)
