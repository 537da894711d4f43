# Copies freelsd-mavlink and the packages that it loads from MODULES to TO. The other packages only generate code, and
# only the native code for PROCESSOR is taken.
file(REMOVE_RECURSE ${TO})
file(GLOB files ${FROM}/*.js)
file(COPY ${files} ${FROM}/package.json DESTINATION ${TO})

set(loaded node-mavlink mavlink-mappings mavlink-mappings-gen xml2js sax xmlbuilder
           serialport @serialport debug ms node-gyp-build)
foreach(package IN LISTS loaded)
  get_filename_component(parent ${package} DIRECTORY)
  file(COPY ${MODULES}/${package} DESTINATION ${TO}/node_modules/${parent}
    REGEX "/(src|examples|typings|mavlink-mappings-gen/node_modules|prebuilds)$" EXCLUDE
    REGEX "[.](d[.]ts|map|md|gyp|tgz|tsbuildinfo|mjs)$" EXCLUDE
    REGEX "(tsconfig[^/]*[.]json|index[.]ts|sanity-check[^/]*|build-test[.]js|dist/cli[.]js)$" EXCLUDE
    REGEX "/LICENSE[^/]*$" EXCLUDE)
endforeach()
# debug keeps its code in src/.
file(COPY ${MODULES}/debug/src DESTINATION ${TO}/node_modules/debug)

if(PROCESSOR MATCHES "^(aarch64|arm64)$")
  set(prebuilt linux-arm64/node.napi.armv8.node)
elseif(PROCESSOR MATCHES "^(x86_64|AMD64)$")
  set(prebuilt linux-x64/node.napi.glibc.node)
else()
  message(WARNING "freelsd-mavlink: serial ports need native code, and there is none for ${PROCESSOR}")
  return()
endif()
get_filename_component(folder ${prebuilt} DIRECTORY)
file(COPY ${MODULES}/@serialport/bindings-cpp/prebuilds/${prebuilt}
  DESTINATION ${TO}/node_modules/@serialport/bindings-cpp/prebuilds/${folder})
