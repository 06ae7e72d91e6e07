#include <momentree/sweep/machines/distribute.hpp>

#include <doctest/doctest.h>

#include <new>

#include <momentree/base/error.hpp>
#include <momentree/sweep/machines/messages.hpp>
#include <momentree/sweep/test_support.hpp>

using namespace momentree;
using namespace momentree::sweep;
using namespace momentree::sweep::test;
using namespace std::chrono_literals;

namespace {

// What conclude() was told.
struct Conclusion {
  int calls = 0;
  Ending ending = Ending::failed;
  std::exception_ptr failure;

  DistributeOptions options(int threads = 1) {
    DistributeOptions result;
    result.threads = threads;
    result.version = "1";
    result.work = "w";
    result.conclude = [this](Ending how, const std::exception_ptr& why) {
      ++calls;
      ending = how;
      failure = why;
      return how == Ending::complete ? 0 : how == Ending::interrupted ? 3 : 1;
    };
    return result;
  }
  std::string problem() const {
    try {
      if (failure) std::rethrow_exception(failure);
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }
};

// A thread that plays a rank; abort() ends it.
std::jthread play(std::function<void()> part) {
  return std::jthread([part = std::move(part)] {
    try {
      part();
    } catch (const Aborted&) {
    }
  });
}

std::jthread worker(Network& network, int rank, const DistributeOptions& options, RunChunk run = squares) {
  return play([&network, rank, options, run = std::move(run)] {
    Network::Rank own(network, rank);
    CHECK(distribute(&own, nullptr, run, options) == 0);
  });
}

// A rank that joins with one thread, takes its first chunk, and never answers again.
std::jthread silent_worker(Network& network, int rank, std::atomic<bool>& has_work) {
  return play([&network, rank, &has_work] {
    Network::Rank own(network, rank);
    own.send(0, encode({MessageKind::hello, {}, 1, {"1", "w", "silent"}}));
    for (;;)
      if (const auto message = own.receive(1s); message && decode(message->bytes).kind == MessageKind::work) has_work = true;
  });
}

}  // namespace

TEST_CASE("one process alone does all the work with its threads") {
  for (const int threads : {1, 3}) {
    Squares source(100, 7);
    Conclusion conclusion;
    int shown = 0;
    DistributeOptions options = conclusion.options(threads);
    options.progress = [&] { ++shown; };
    CHECK(distribute(nullptr, &source, squares, options) == 0);
    CHECK(conclusion.calls == 1);
    CHECK(conclusion.ending == Ending::complete);
    CHECK(source.items_done == 100);
    CHECK(source.wrong == 0);
    CHECK(shown > 0);
  }
}

TEST_CASE("work that was complete before needs no chunk") {
  Squares source(0, 1);
  Conclusion conclusion;
  CHECK(distribute(
            nullptr, &source, [](Chunk) -> std::string { throw std::bad_alloc(); }, conclusion.options()) == 0);
  CHECK(conclusion.ending == Ending::complete);
}

TEST_CASE("several ranks with several threads each do every chunk, and all of them finish") {
  Network network(4);
  Squares source(1000, 3);
  Conclusion conclusion;
  const DistributeOptions options = conclusion.options(2);
  std::atomic<int> elsewhere = 0;
  {
    std::vector<std::jthread> others;
    for (int rank = 1; rank < 4; ++rank)
      others.push_back(worker(network, rank, options, [&](Chunk chunk) {
        ++elsewhere;
        return squares(chunk);
      }));
    Network::Rank own(network, 0);
    // The first chunk of rank 0 waits for one of another rank.
    CHECK(distribute(
              &own, &source,
              [&](Chunk chunk) {
                while (elsewhere == 0) std::this_thread::sleep_for(1ms);
                return squares(chunk);
              },
              options) == 0);
  }
  CHECK(source.items_done == 1000);
  CHECK(source.wrong == 0);
  CHECK(conclusion.calls == 1);
  CHECK(elsewhere > 0);
  CHECK(network.finished() == 4);
  CHECK(network.code() == -1);
}

TEST_CASE("the chunks of an unresponsive rank are computed by others; results are published before it is ended") {
  Network network(2);
  Squares source(20, 1);
  Conclusion conclusion;
  DistributeOptions options = conclusion.options();
  options.grace = 50ms;
  std::string warning;
  int concluded_at_warning = 0;
  options.warn = [&](const std::string& text) {
    warning = text;
    concluded_at_warning = conclusion.calls;
  };
  std::atomic<bool> has_work = false;
  const std::jthread silent = silent_worker(network, 1, has_work);
  Network::Rank own(network, 0);
  int code = -1;
  try {
    (void)distribute(
        &own, &source,
        [&](Chunk chunk) {
          while (!has_work) std::this_thread::sleep_for(1ms);
          return squares(chunk);
        },
        options);
  } catch (const Aborted& aborted) {
    code = aborted.code;
  }
  CHECK(code == 0);
  CHECK(source.items_done == 20);
  CHECK(source.given_again >= 1);
  CHECK(conclusion.ending == Ending::complete);
  CHECK(concluded_at_warning == 1);
  CHECK(warning == "rank 1 (silent) did not answer and was ended");
}

TEST_CASE("a rank that never says hello does not hold up the others") {
  Network network(2);
  Squares source(5, 1);
  Conclusion conclusion;
  DistributeOptions options = conclusion.options();
  options.grace = 10ms;
  Network::Rank own(network, 0);
  CHECK_THROWS_AS((void)distribute(&own, &source, squares, options), Aborted);
  CHECK(conclusion.ending == Ending::complete);
  CHECK(source.items_done == 5);
}

TEST_CASE("a chunk that takes long on one rank is given to another, and the run does not wait for the slow one") {
  Network network(3);
  Squares source(12, 1);
  Conclusion conclusion;
  const DistributeOptions options = conclusion.options();
  std::atomic<bool> cancelled = false, slow_started = false;
  DistributeOptions slow = options;
  slow.cancel = &cancelled;
  const auto after_slow = [&](Chunk chunk) {
    while (!slow_started) std::this_thread::sleep_for(1ms);
    return squares(chunk);
  };
  {
    const std::jthread fast = worker(network, 1, options, after_slow);
    const std::jthread slower = worker(network, 2, slow, [&](Chunk chunk) {  // ends only when it is no longer needed
      slow_started = true;
      while (!cancelled) std::this_thread::sleep_for(1ms);
      return squares(chunk);
    });
    Network::Rank own(network, 0);
    CHECK(distribute(&own, &source, after_slow, options) == 0);
  }
  CHECK(source.items_done == 12);
  CHECK(source.given_again >= 1);
  CHECK(network.finished() == 3);
}

TEST_CASE("a result that comes twice is handed on twice and harms nothing") {
  Network network(2);
  Squares source(6, 1);
  Conclusion conclusion;
  {
    const std::jthread twice = play([&] {
      Network::Rank own(network, 1);
      own.send(0, encode({MessageKind::hello, {}, 1, {"1", "w", "h"}}));
      for (;;) {
        const auto message = own.receive(1s);
        if (!message) continue;
        const Note note = decode(message->bytes);
        if (note.kind == MessageKind::work)
          for (int i = 0; i < 2; ++i) own.send(0, encode({MessageKind::result, note.chunk, 0.001, {squares(note.chunk)}}));
        if (note.kind == MessageKind::stop) own.send(0, encode({MessageKind::ended}));
        if (note.kind == MessageKind::leave) return own.finish();
      }
    });
    Network::Rank own(network, 0);
    CHECK(distribute(
              &own, &source,
              [&](Chunk chunk) {
                while (source.calls < 2) std::this_thread::sleep_for(1ms);
                return squares(chunk);
              },
              conclusion.options()) == 0);
  }
  CHECK(source.items_done == 6);
  CHECK(source.wrong == 0);
  CHECK(source.calls > 6);
}

TEST_CASE("ranks with another version or other input are refused") {
  for (const bool version : {true, false}) {
    Network network(2);
    Squares source(1000000, 1);
    Conclusion conclusion;
    DistributeOptions other = conclusion.options();
    (version ? other.version : other.work) = "2";
    {
      const std::jthread wrong = worker(network, 1, other);
      Network::Rank own(network, 0);
      CHECK(distribute(
                &own, &source,
                [](Chunk chunk) {
                  std::this_thread::sleep_for(1ms);
                  return squares(chunk);
                },
                conclusion.options()) == 1);
    }
    CHECK(conclusion.ending == Ending::failed);
    CHECK(conclusion.problem().find("rank 1 (") != std::string::npos);
    CHECK(conclusion.problem().find(version ? "runs version 2 of momentree, and rank 0 version 1"
                                            : "has read other files than rank 0") != std::string::npos);
    CHECK(network.finished() == 2);
  }
}

TEST_CASE("an error or a lack of memory on any rank ends all of them with that message") {
  for (const int rank : {0, 1}) {
    for (const bool memory : {false, true}) {
      Network network(2);
      Squares source(1000000, 1);
      Conclusion conclusion;
      const auto run = [&](int own) {
        return [&, own](Chunk chunk) -> std::string {
          std::this_thread::sleep_for(1ms);
          if (own == rank && memory) throw std::bad_alloc();
          if (own == rank) throw Error{"this is wrong", "s.toml:3:1", "mend it"};
          return squares(chunk);
        };
      };
      {
        const std::jthread other = worker(network, 1, conclusion.options(), run(1));
        Network::Rank own(network, 0);
        CHECK(distribute(&own, &source, run(0), conclusion.options()) == 1);
      }
      const std::string where = rank == 1 ? " (on rank 1)" : "";
      if (memory && rank == 0)
        CHECK_THROWS_AS(std::rethrow_exception(conclusion.failure), std::bad_alloc);
      else if (memory)
        CHECK(conclusion.problem() == "error: out of memory" + where + "; use fewer ranks or threads on each machine");
      else
        CHECK(conclusion.problem() == "s.toml:3:1: error: this is wrong" + where + "; mend it");
      CHECK(network.finished() == 2);
    }
  }
}

TEST_CASE("a result that cannot be stored ends the work") {
  Network network(2);
  Squares source(1000000, 1);
  source.on_finished = [] { throw Error{"no space left", "journal", ""}; };
  Conclusion conclusion;
  {
    const std::jthread other = worker(network, 1, conclusion.options());
    Network::Rank own(network, 0);
    CHECK(distribute(&own, &source, squares, conclusion.options()) == 1);
  }
  CHECK(conclusion.problem() == "journal: error: no space left");
}

TEST_CASE("an interrupt on any rank ends all of them, and what chunks then throw does not matter") {
  for (const int rank : {0, 1}) {
    Network network(2);
    Squares source(1000000, 1);
    Conclusion conclusion;
    std::atomic<bool> stop = false;
    const auto run = [&](int own) {
      return [&, own](Chunk chunk) -> std::string {
        std::this_thread::sleep_for(1ms);
        if (own == rank && chunk.first > 10) stop = true;
        if (own == rank && stop) throw Error{"interrupted", "", ""};
        return squares(chunk);
      };
    };
    const auto options = [&](int own) {
      DistributeOptions result = conclusion.options();
      if (own == rank) result.stop = &stop;
      return result;
    };
    {
      const std::jthread other = worker(network, 1, options(1), run(1));
      Network::Rank own(network, 0);
      CHECK(distribute(&own, &source, run(0), options(0)) == 3);
    }
    CHECK(conclusion.ending == Ending::interrupted);
    CHECK(source.wrong == 0);
    CHECK(network.finished() == 2);
  }
}
