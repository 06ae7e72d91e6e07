#pragma once
// Misuse of the library, each in a separate process: the program must abort with a message that states the violated precondition.
// doctest does not support such tests; POSIX only.
#include <csignal>
#include <cstdio>
#include <functional>
#include <string>

#include <sys/wait.h>
#include <unistd.h>

#include <doctest/doctest.h>

namespace momentree::test {

/// What a child process printed to standard error, and its exit code or the signal that ended it (0: none).
struct End {
  std::string said;
  int signal = 0, code = 0;
};
inline End in_child(const std::function<void()>& misuse) {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  std::fflush(nullptr);
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    alarm(20);  // a process that hangs is as wrong as one that continues
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    for (const int signal : {SIGABRT, SIGSEGV, SIGTERM}) std::signal(signal, SIG_DFL);
    try {
      misuse();
    } catch (...) {  // otherwise the child would run the remaining tests
      _exit(1);
    }
    _exit(0);
  }
  close(ends[1]);
  End end;
  char buffer[512];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) end.said.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
  if (WIFEXITED(status)) end.code = WEXITSTATUS(status);
  return end;
}

/// A misuse, and part of the expected message.
struct Misuse {
  std::string how, expected;
  std::function<void()> act;
};

inline void check_stopped(const Misuse& misuse) {
  CAPTURE(misuse.how);
  const End end = in_child(misuse.act);
  INFO(end.said);
  CHECK(end.signal == SIGABRT);
  CHECK(end.said.find("was used wrongly: ") != std::string::npos);
  CHECK(end.said.find(misuse.expected) != std::string::npos);
}
inline void check_stopped(const std::string& how, const std::string& expected, const std::function<void()>& act) {
  check_stopped(Misuse{how, expected, act});
}

/// Correct use, to show that the misuses fail for the intended reason.
inline void check_fine(const std::string& how, const std::function<void()>& act) {
  CAPTURE(how);
  const End end = in_child(act);
  INFO(end.said);
  CHECK(end.signal == 0);
  CHECK(end.code == 0);
}

}  // namespace momentree::test
