# Shell completions and the manual page, as printed by the program: cmake -DPROGRAM=… -DFOLDER=… -P ShellFiles.cmake
file(MAKE_DIRECTORY "${FOLDER}")
function(write_file name)
  execute_process(COMMAND "${PROGRAM}" ${ARGN} OUTPUT_FILE "${FOLDER}/${name}" COMMAND_ERROR_IS_FATAL ANY)
endfunction()
write_file(momentree.bash completion bash)
write_file(_momentree completion zsh)
write_file(momentree.fish completion fish)
write_file(momentree.1 man-page)
