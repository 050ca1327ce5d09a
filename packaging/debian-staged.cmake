# What Debian has otherwise than others have it, once a package is staged: pages and histories are compressed, and zsh
# finds the completions of packages in a folder of their own.
file(GLOB_RECURSE pages ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/share/man/*.[1-8])
file(GLOB histories ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/share/doc/*/changelog)
execute_process(COMMAND gzip -9n ${pages} ${histories} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB zsh ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/*/usr/share/zsh)
foreach(folder ${zsh})
  file(RENAME ${folder}/site-functions ${folder}/vendor-completions)
endforeach()
