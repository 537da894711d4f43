# cmake --install: the server with what it looks for beside itself, ../share/freelsd.
include(GNUInstallDirs)
install(TARGETS freelsd-server RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${PROJECT_SOURCE_DIR}/engine/classification/grass_model.yml
        DESTINATION ${CMAKE_INSTALL_DATADIR}/freelsd)
install(DIRECTORY ${PROJECT_BINARY_DIR}/web/static/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/freelsd/web)
