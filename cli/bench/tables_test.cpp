// The tables of `momentree bench`, with minimal time per figure: checks their contents, never the speed.
#include <cli/bench/peers.hpp>
#include <cli/bench/tables.hpp>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include <momentree/base/error.hpp>
#include <momentree/scenario/test_support.hpp>

namespace momentree::cli {

TEST_CASE("operations: rows of others as printed, momentree's as counted") {
  const std::vector<OperationsRow> rows = operations_table();
  REQUIRE(rows.size() == 6);
  CHECK(rows[2].total == "432 n − 688");
  CHECK(rows[2].of_100 == 432 * 100 - 688);
  CHECK(rows[4].total == "363 n − 475");
  CHECK(rows[4].of_100 == 363 * 100 - 475);
  for (const std::size_t unreadable : {0u, 1u, 3u}) {
    CHECK(rows[unreadable].of_100 == 0);
    CHECK(rows[unreadable].total.starts_with("…"));
    CHECK(rows[unreadable].multiplications == "not readable");
  }
  const OperationsRow& ours = rows[5];
  CHECK(ours.algorithm == "momentree");
  CHECK(ours.total == "315 n − 434");
  CHECK(ours.additions == "155 n − 224");
  CHECK(ours.multiplications == "160 n − 210");
  CHECK(ours.of_100 == 315 * 100 - 434);
  const std::vector<OperationsRow> others = other_operations();
  REQUIRE(others.size() == 3);
  CHECK(others[0].total == "350 n − 465");
  CHECK(others[1].total == "67 n − 24");
  CHECK(others[2].total == "77 n − 28");
}

TEST_CASE("the breaking chain: four evaluations a step, one change") {
  const BreakingChain chain = breaking_chain(1);
  CHECK(chain.evaluations[0] >= 7200);
  CHECK(chain.evaluations[1] >= 4800);
  CHECK(chain.evaluations[0] + chain.evaluations[1] < 12100);
  for (const double time : {chain.evaluation[0], chain.evaluation[1], chain.change, chain.whole}) CHECK(time > 0);
}

TEST_CASE("times of evaluations and changes: every model, results right") {
  std::set<std::string> models, changes;
  int rows = 0;
  evaluation_times(0, [&](const EvaluationRow& row) {
    models.insert(row.model);
    CHECK(row.seconds > 0);
    CHECK(row.error < 1e-9);
    CHECK(row.dofs == (row.model == "humanoid" ? 36 : row.bodies));
    return ++rows < 100;
  });
  CHECK(rows == 10);
  CHECK(models == std::set<std::string>{"planar chain", "spatial chain", "binary tree", "humanoid"});
  change_times(0, [&](const ChangeRow& row) {
    changes.insert(row.change);
    CHECK(row.seconds > 0);
    return true;
  });
  CHECK(changes == std::set<std::string>{"break a joint", "lock a joint", "re-root"});
  rows = 0;
  evaluation_times(0, [&](const EvaluationRow&) { return ++rows < 2; });  // it stops when requested
  CHECK(rows == 2);
}

TEST_CASE("generated code: fewer operations, the same rates") {
  int rows = 0;
  const std::string none = generated_times(0, [&](const GeneratedRow& row) {
    CHECK(row.operations[1] < row.operations[0]);
    CHECK(row.seconds[0] > 0);
    CHECK(row.seconds[1] > 0);
    CHECK(row.error < 1e-9);
    return ++rows < 2;  // the arm, the shortest chain
  });
  if (!none.empty()) {  // there is no machine code here
    MESSAGE(none);
    return;
  }
  CHECK(rows == 2);
}

TEST_CASE("momentree bench: tables for people, one document for programs") {
  const io::test::TemporaryFolder folder;
  const auto call = [&](const char* arguments) {
    const std::string file = folder / "out";
    CHECK(std::system(("'" MOMENTREE_PROGRAM "' bench " + std::string(arguments) + " >'" + file + "'").c_str()) == 0);
    std::ostringstream text;
    text << std::ifstream(file).rdbuf();
    return text.str();
  };
  const std::string text = call("--bodies 20000");
  for (const char* words :
       {"Featherstone 1987", "275 n …", "432 n − 688", "363 n − 475", "315 n − 434", "54.0 µs", "planar chain", "humanoid",
        "Generated code", "break a joint", "per body", "bench/peers", "rope", "all bodies differ"})
    CHECK_MESSAGE(text.find(words) != std::string::npos, words);
  const nlohmann::json json = nlohmann::json::parse(call("--json --bodies 20000"));
  CHECK(json.at("operations").size() == 6);
  CHECK(json.at("operations").at(0).at("of_100").is_null());
  CHECK(json.at("evaluations").size() == 10);
  CHECK(json.at("changes").size() == 12);
  CHECK(json.at("generated").size() == 9);
  CHECK(json.at("breaking_chain").at("change_ns") > 0);
  const nlohmann::json& large = json.at("large_worlds");
  REQUIRE(large.size() == 2);
  for (const nlohmann::json& row : large) {
    CHECK(row.at("bodies") == 20000);
    CHECK(row.at("ns_per_body") > 0);
#ifdef __linux__
    CHECK(row.at("bytes_per_body") > 100);
    CHECK(row.at("bytes_per_body_with_motions").get<double>() > row.at("bytes_per_body").get<double>() + 90);
#endif
  }
#ifdef __linux__
  // Equal joints, masses and placements are stored once. So few bodies leave pages half used: a million bodies need 535 and 1295
  // bytes each.
  for (const char* key : {"bytes_per_body", "bytes_per_body_with_motions"}) {
    CHECK(large.at(0).at(key) < (key == std::string("bytes_per_body") ? 900 : 1400));
    CHECK(large.at(0).at(key).get<double>() + 300 < large.at(1).at(key));
  }
#endif
}

TEST_CASE("momentree bench --peers: runs the programs of a folder, and discards the results of failures") {
  const io::test::TemporaryFolder folder;
  const auto program = [&](const char* name, const std::string& script) {
    std::ofstream(folder / name) << "#!/bin/sh\n" << script;
    std::filesystem::permissions(folder / name, std::filesystem::perms::owner_all);
    return folder / name;
  };
  CHECK_THROWS_AS(peer_programs(folder / "nothing"), Error);
  const std::string line = R"({"model": "planar chain 10", "engine": "E 1", "way": "f", "imbalance": 1e-12, "ns_per_body": 250})";
  const std::string good = program("peer-a", "[ \"$1\" = evaluate ] && echo '" + line + "' && echo '" + line + "'\n");
  const std::string ours = program("peer-momentree", "echo '" + line + "'\n");
  program("other", "exit 1\n");
  CHECK(peer_programs(folder / "") == std::vector{ours, good});
  std::vector<PeerRow> rows;
  const auto keep = [&](const PeerRow& row) { return rows.push_back(row), true; };
  peer_evaluations(good, {}, keep);
  REQUIRE(rows.size() == 2);
  CHECK(rows[1].engine == "E 1");
  CHECK(rows[1].way == "f");
  CHECK(rows[1].model == "planar chain 10");
  CHECK(rows[1].ns_per_body == 250);
  CHECK(rows[1].imbalance == 1e-12);
  int count = 0;
  peer_evaluations(program("endless", "while :; do echo '" + line + "'; done\n"), {},
                   [&](const PeerRow&) { return ++count < 3; });
  CHECK(count == 3);
  CHECK_THROWS_AS(peer_evaluations(program("failing", "echo '" + line + "'; exit 1\n"), {}, keep), Error);
  CHECK_THROWS_AS(peer_evaluations(program("talking", "echo Welcome\n"), {}, keep), Error);
  CHECK_THROWS_AS(peer_evaluations(program("short", "echo '{\"model\": \"a\"}'\n"), {}, keep), Error);
  CHECK_THROWS_AS(peer_evaluations(folder / "missing", {}, keep), Error);
  CHECK(std::system(
            ("'" MOMENTREE_PROGRAM "' bench --peers '" + (folder / "nothing") + "' 2>'" + (folder / "said") + "'").c_str()) ==
        2 << 8);
}

TEST_CASE("momentree bench MODEL: a user's own models, in momentree and other engines") {
  const io::test::TemporaryFolder folder;
  const auto call = [&](const std::string& arguments) {
    return std::system(
               ("'" MOMENTREE_PROGRAM "' bench " + arguments + " >'" + (folder / "out") + "' 2>'" + (folder / "err") + "'")
                   .c_str()) >>
           8;
  };
  const auto text = [&](const char* name) {
    std::ostringstream all;
    all << std::ifstream(folder / name).rdbuf();
    return all.str();
  };
  const std::string sources = MOMENTREE_SOURCE_DIR "/scenarios/";
  const std::string panda = "'" + sources + "models/panda/panda.urdf'",
                    humanoid = "'" + sources + "models/mjcf_humanoid/humanoid.xml'",
                    chimney = "'" + sources + "falling_chimney.toml'";
  REQUIRE(call("--json " + panda + " " + humanoid + " " + chimney) == 0);
  const nlohmann::json json = nlohmann::json::parse(text("out"));
  CHECK(!json.contains("peers"));
  const nlohmann::json& rows = json.at("models");
  REQUIRE(rows.size() == 3);
  CHECK(rows.at(0).at("model") == "panda");
  CHECK(rows.at(0).at("freedoms") == 9);
  CHECK(rows.at(1).at("broken") == "humanoid/ankle_x_right");
  for (const nlohmann::json& row : rows) {
    for (const char* key : {"evaluation_ns", "accelerations_ns", "break_ns"}) CHECK_MESSAGE(row.at(key) > 0, key);
    CHECK(row.at("error") < 1e-9);
  }

  // A program is given the models one by one; a model that it does not support is left out there.
  const std::string program = folder / "peer-a";
  std::ofstream(program) << "#!/bin/sh\n[ \"$1\" = evaluate ] && grep -q prismatic \"$2\" || exit 1\n"
                            "echo '{\"model\": \"'$(head -1 \"$2\")'\", \"engine\": \"E 1\", \"way\": \"f\", \"imbalance\": 0, "
                            "\"ns_per_body\": '$(wc -l <\"$2\")'}'\n";
  std::filesystem::permissions(program, std::filesystem::perms::owner_all);
  REQUIRE(call("--json --peers '" + (folder / "") + "' " + panda + " " + humanoid) == 0);
  const nlohmann::json beside = nlohmann::json::parse(text("out"));
  const nlohmann::json& peers = beside.at("peers");
  REQUIRE(peers.size() == 1);
  CHECK(peers.at(0).at("model") == "panda");
  CHECK(peers.at(0).at("ns_per_body") == 10);  // nine moving bodies and a line with the name
  CHECK(text("err").find("left out") != std::string::npos);

  CHECK(call("'" + sources + "models/cassie/cassie_v2.sdf'") == 2);  // closed loops
  CHECK(text("err").find("closed loops are not measured: joint 'cassie_v2/left-pitch-rod-joint' closes one") !=
        std::string::npos);
  CHECK(call("nowhere.urdf") == 2);
  CHECK(call("--peers '" + (folder / "") + "' '" + sources + "capture.toml'") == 2);  // it has a universal joint
  CHECK(text("err").find("capture.toml: error: other engines do not support this model: tug/upper has a universal joint") !=
        std::string::npos);
}

TEST_CASE("momentree bench: an installation without momentree-measure") {
  const io::test::TemporaryFolder folder;
  std::filesystem::copy_file(MOMENTREE_PROGRAM, folder / "momentree");
  CHECK(std::system(("'" + (folder / "momentree") + "' bench 2>'" + (folder / "said") + "'").c_str()) == 2 << 8);
  std::ostringstream said;
  said << std::ifstream(folder / "said").rdbuf();
  CHECK(said.str().find("cannot start momentree-measure") != std::string::npos);
}

}  // namespace momentree::cli
