# Pages and histories are compressed in Debian packages, once they are staged.
file(GLOB_RECURSE pages ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/share/man/*.[1-8])
file(GLOB histories ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/share/doc/*/changelog)
execute_process(COMMAND gzip -9n ${pages} ${histories} COMMAND_ERROR_IS_FATAL ANY)
