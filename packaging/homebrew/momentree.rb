class Momentree < Formula
  desc "Dynamics of mechanisms whose topology changes while they move"
  homepage "@HOMEPAGE@"
  url "@URL@"
  sha256 "@SHA256@"
  license "Apache-2.0"

  depends_on "cli11" => :build
  depends_on "cmake" => :build
  depends_on "ninja" => :build
  depends_on "nlohmann-json" => :build
  depends_on "tomlplusplus" => :build
  depends_on "expat"
  depends_on :linux

  def install
    args = %w[
      -DMOMENTREE_BENCH=OFF
      -DMOMENTREE_HDF5=OFF
      -DMOMENTREE_MPI=OFF
      -DMOMENTREE_TESTS=OFF
    ]
    system "cmake", "-S", ".", "-B", "build", "-G", "Ninja", *args, *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    (testpath/"rod.toml").write <<~TOML
      format = 1
      [[mechanism]]
      name = "m"
      [[mechanism.body]]
      name = "rod"
      mass = 1
      com = [0.5, 0, 0]
      inertia = 0.1
      [mechanism.body.joint]
      kind = "revolute"
      axis = [0, 1, 0]
      [[event]]
      at = "0.1 s"
      break = "m/rod"
      [integrate]
      until = "0.2 s"
    TOML
    system bin/"momentree", "run", "rod.toml", "--out", "result"
    assert_equal 1, (testpath/"result/events.jsonl").read.lines.size

    (testpath/"test.cpp").write <<~CPP
      #include <momentree/momentree.hpp>
      int main() {
        using namespace momentree;
        Model model;
        model.add({.name = "rod", .mass = 1, .com = {0.5, 0, 0}, .inertia = diagonal(0.1), .joint = Revolute{.axis = y_axis}});
        Simulation simulation(model);
        return simulation.run_until(0.1) ? 0 : 1;
      }
    CPP
    system ENV.cxx, "-std=c++20", "test.cpp", "-I#{include}", "-L#{lib}", "-lmomentree_batch", "-lmomentree_core",
           "-pthread", "-o", "test"
    system "./test"
  end
end
