# Run by CPack between installing into its folder and packing that folder.
set(root ${CPACK_TEMPORARY_DIRECTORY})
get_filename_component(source_dir ${CMAKE_CURRENT_LIST_DIR}/../.. ABSOLUTE)
set(doc ${root}/usr/share/doc/freelsd)

function(run)
  execute_process(COMMAND ${ARGN} COMMAND_ERROR_IS_FATAL ANY)
endfunction()

function(put file target)
  configure_file(${source_dir}/${file} ${target} COPYONLY)
endfunction()

put(deploy/config.example.json ${root}/etc/freelsd/config.json)
put(deploy/freelsd.service ${root}/lib/systemd/system/freelsd.service)
put(deploy/freelsd-mavlink@.service ${root}/lib/systemd/system/freelsd-mavlink@.service)
put(deploy/mavlink.example.conf ${doc}/examples/mavlink.conf)
put(deploy/debian/copyright ${doc}/copyright)
put(deploy/debian/lintian-overrides ${root}/usr/share/lintian/overrides/freelsd)
put(deploy/README.md ${doc}/README.md)
put(deploy/nginx.conf ${doc}/examples/nginx.conf)
put(CHANGELOG.md ${doc}/changelog)

# What changed stands in CHANGELOG.md; Debian also wants a word about each version of the package.
if(DEFINED ENV{SOURCE_DATE_EPOCH})
  set(date --date=@$ENV{SOURCE_DATE_EPOCH})
endif()
execute_process(COMMAND date --utc --rfc-email ${date} OUTPUT_VARIABLE now
                OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
file(WRITE ${doc}/changelog.Debian
"freelsd (${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE}) bookworm; urgency=medium

  * freelsd ${CPACK_PACKAGE_VERSION}; see changelog.gz for what is new.

 -- ${CPACK_PACKAGE_CONTACT}  ${now}
")

# As dh_strip does.
run(${CPACK_FREELSD_STRIP} --strip-unneeded --remove-section=.comment --remove-section=.note
    ${root}/usr/bin/freelsd-server)
file(GLOB pages ${root}/usr/share/man/man*/*.[1-9])
foreach(file ${doc}/changelog ${doc}/changelog.Debian ${pages})
  run(gzip -9nf ${file})
endforeach()
# Whatever the umask was.
run(chmod -R u=rwX,go=rX ${root})
