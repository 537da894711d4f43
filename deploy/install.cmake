# cmake --install: the server with what it looks for beside itself, ../share/freelsd, and freelsdctl.
# Not freelsd-train: it works on the labelled photographs of the sources.
include(GNUInstallDirs)
install(TARGETS freelsd-server RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(PROGRAMS ${PROJECT_SOURCE_DIR}/deploy/freelsdctl DESTINATION ${CMAKE_INSTALL_BINDIR})
install(FILES ${PROJECT_SOURCE_DIR}/deploy/freelsdctl.bash-completion
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME freelsdctl)
install(FILES ${PROJECT_SOURCE_DIR}/deploy/freelsdctl.1 ${PROJECT_SOURCE_DIR}/deploy/freelsd-mavlink.1
        DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_SOURCE_DIR}/deploy/freelsd-server.8 DESTINATION ${CMAKE_INSTALL_MANDIR}/man8)
install(FILES ${PROJECT_SOURCE_DIR}/engine/ground_kind/ground_kind.onnx
              ${PROJECT_SOURCE_DIR}/engine/ground_kind/ground_kind.json
              ${PROJECT_SOURCE_DIR}/engine/classification/paper_model.yml
        DESTINATION ${CMAKE_INSTALL_DATADIR}/freelsd)
# Without npm there is none.
install(DIRECTORY ${PROJECT_BINARY_DIR}/lib/freelsd/mavlink DESTINATION lib/freelsd OPTIONAL USE_SOURCE_PERMISSIONS)
install(CODE "
  if(EXISTS \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/lib/freelsd/mavlink/freelsd-mavlink.js\")
    file(CREATE_LINK ../lib/freelsd/mavlink/freelsd-mavlink.js
         \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/bin/freelsd-mavlink\" SYMBOLIC)
  endif()")
install(DIRECTORY ${PROJECT_BINARY_DIR}/share/freelsd/web/
        DESTINATION ${CMAKE_INSTALL_DATADIR}/freelsd/web)
