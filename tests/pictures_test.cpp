// Tests of plot, film and pictures of other commands: sizes, colours, text, and no file replaced silently.
#include <doctest/doctest.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include "tests/gas_text.hpp"
#include "tests/program.hpp"

namespace pictures_test {

using namespace lichtenberg;
namespace fs = std::filesystem;

namespace {

/// Scene of two plates at +-10 kV and a sphere that moves from one to the other: 6 frames, 20 ms.
const std::string plates = R"(
title = "Plates"
[domain]
size = [8e-3, 8e-3]
left = { potential = 10e3 }
right = { potential = -10e3 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [0.6e-3, 4e-3]
radius = 0.6e-3
[effects.floating_conductors]
[effects.stokes_drag]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 6e-6
[field]
cells = 32
[output]
every = 0.004
picture = false
[stop]
time = 0.02
stationary = false
)";

/// Scene of three charged spheres in a row that touch the ground and each other. All are at 0 V from the start.
const std::string chain = R"(
title = "Chain"
[domain]
size = [8e-3, 8e-3]
bottom = { potential = 0 }
[medium]
relative_permittivity = 4.7
viscosity = 0.7
[[conductor]]
position = [4e-3, 0.55e-3]
radius = 0.5e-3
[[conductor]]
position = [4e-3, 1.6e-3]
radius = 0.5e-3
[[conductor]]
position = [4e-3, 2.65e-3]
radius = 0.5e-3
[effects.floating_conductors]
[effects.current_injection]
current = 1e-12
[effects.stokes_drag]
[effects.hertz_contact]
[effects.wall_contact]
[effects.contact_discharge]
contact_distance = 0.2e-3
[field]
cells = 32
[output]
every = 0.004
picture = false
[stop]
time = 0.012
stationary = false
)";

Ended run_without_error(const Folder& folder, const std::string& arguments) {
  const Ended ended = run_program(folder, arguments);
  INFO(arguments, ": ", ended.err);
  CHECK(ended.status == 0);
  return ended;
}

/// Folder in which a scene has been run as scene.h5.
struct RunFolder : Folder {
  explicit RunFolder(const std::string& scene) {
    write("scene.toml", scene);
    run_without_error(*this, "run scene.toml --quiet");
  }
};

/// Value of a Python expression for a picture. `p` has its colours, [height][width][red, green, blue] from 0 to 1, with
/// row 0 at the top.
double evaluate_picture(const Folder& folder, const std::string& picture, const std::string& expression) {
  folder.write("look.py",
               fmt::format("import matplotlib.image, numpy as np\np = matplotlib.image.imread('{}')[..., :3]\n"
                           "print(float({}))\n",
                           picture, expression));
  const Ended looked = run_shell(folder, "/usr/bin/python3 look.py");
  REQUIRE_MESSAGE(looked.status == 0, looked.err);
  return std::stod(looked.out);
}

/// Pixel at the fractions x and y of width and height from the lower left of a square panel. The panel is 5 inches wide
/// and starts at (0.22, 0.4) of 6.24 x 6.02 inches; a narrower panel occupies less.
std::string pixel(double x, double y) {
  return fmt::format("p[int((6.02 - .4 - 5 * {}) / 6.02 * p.shape[0]), int((.22 + 5 * {}) / 6.24 * p.shape[1])]", y, x);
}

void check_refused(const Folder& folder, const std::string& arguments, const std::string& sentence) {
  const Ended ended = run_program(folder, arguments);
  INFO(arguments, ": ", ended.err);
  CHECK(ended.status == 2);
  CHECK(contains(ended.err, sentence));
  CHECK(std::count(ended.err.begin(), ended.err.end(), '\n') == 1);
}

}  // namespace

TEST_CASE("plot: frames have equal layout and colour scale, and show their field") {
  const RunFolder folder(plates);
  const Ended drawn = run_without_error(folder, "plot scene.h5 --frames 0,2:4:2");
  CHECK(drawn.out ==
        "scene-frame-0-potential.png shows frame 0 by potential\nscene-frame-2-potential.png shows frame 2 by "
        "potential\nscene-frame-4-potential.png shows frame 4 by potential\n");
  for (const std::string picture : {"scene-frame-0-potential.png", "scene-frame-4-potential.png"}) {
    CHECK(evaluate_picture(folder, picture, "p.shape[1]") == 1248);  // 6.24 inches at 200 points per inch.
    CHECK(evaluate_picture(folder, picture, "p.shape[0]") == 1204);
    // Positive is red and negative is blue, darker near the plates. The ends of RdBu are 0.40, 0.00, 0.12 and 0.02,
    // 0.19, 0.38.
    CHECK(evaluate_picture(folder, picture, pixel(0.02, 0.9) + "[0]") == doctest::Approx(0.45).epsilon(0.2));
    CHECK(evaluate_picture(folder, picture, pixel(0.02, 0.9) + "[2]") < 0.2);
    CHECK(evaluate_picture(folder, picture, pixel(0.98, 0.9) + "[2]") == doctest::Approx(0.45).epsilon(0.2));
    CHECK(evaluate_picture(folder, picture, pixel(0.98, 0.9) + "[0]") < 0.1);
  }
  // An open range starts at the first frame or ends at the last, for any step.
  CHECK(contains(run_without_error(folder, "plot scene.h5 --frames :1,5::2147483647 --colour speed").out,
                 "shows frame 5 by speed"));
  CHECK(fs::exists(folder / "scene-frame-0-speed.png"));
  // The colour bar and its labels, right of the panel, are the same.
  CHECK(evaluate_picture(
            folder, "scene-frame-0-potential.png",
            "abs(p[200:, 1060:] - matplotlib.image.imread('scene-frame-4-potential.png')[200:, 1060:, :3]).max()") ==
        0);
  // The run's picture shows the field of its file, on the scene's 32 cells. The field solved again on 256 cells differs
  // only near the sphere, in 5 % of the picture, by at most 10 % of the colour range.
  run_without_error(folder, "run scene.toml --overwrite --quiet --set output.picture=true");
  run_without_error(folder, "plot scene.h5 --frames 4,5 --out solved.png");
  const auto difference = [&](const std::string& other) {
    return evaluate_picture(
        folder, "scene.png",
        "abs(p[200:1000, 60:1000] - matplotlib.image.imread('" + other + "')[200:1000, 60:1000, :3]).mean()");
  };
  CHECK(difference("solved-5.png") < 0.005);
  CHECK(difference("solved-4.png") > 0.005);  // The sphere has another position there.
}

TEST_CASE("plot: text and colours follow the options in PNG, PDF and SVG") {
  const RunFolder folder(plates);
  run_without_error(folder, "plot scene.h5 --frame 1 --out a.svg --range=-20e3,5e3");
  const std::string words = text_of(folder / "a.svg");
  for (const std::string word : {"potential (kV)", "Plates", "t = 0.004 s, N = 1", "connected to an electrode", "1 mm"})
    CHECK_MESSAGE(contains(words, word), word);
  CHECK_FALSE(contains(words, "ground"));
  CHECK_FALSE(contains(words, ">10<"));  // The colour bar ends at 5 kV.
  CHECK(contains(words, "20<"));
  run_without_error(folder, "plot scene.h5 --out a.pdf");
  CHECK(text_of(folder / "a.pdf").starts_with("%PDF"));
  // viridis ends in purple and yellow: 0.27, 0.00, 0.33 and 0.99, 0.91, 0.14.
  run_without_error(folder, "plot scene.h5 --cmap viridis --out viridis.png");
  CHECK(evaluate_picture(folder, "viridis.png", pixel(0.01, 0.9) + "[1]") > 0.8);
  CHECK(evaluate_picture(folder, "viridis.png", pixel(0.99, 0.9) + "[1]") < 0.1);
  for (const std::string colour : {"charge", "force", "cluster", "speed"}) {
    run_without_error(folder, "plot scene.h5 --colour " + colour);
    // There is no field in the background.
    CHECK(evaluate_picture(folder, "scene-frame-5-" + colour + ".png", pixel(0.5, 0.8) + ".min()") == 1);
  }
}

TEST_CASE("plot with all conductors at 0 V: shows the currents of the tree") {
  const RunFolder folder(chain);
  CHECK(contains(run_without_error(folder, "plot scene.h5 --out chain.svg").out, "by current"));
  const std::string words = text_of(folder / "chain.svg");
  CHECK(contains(words, "100 % connected to the ground, all at 0 V"));
  CHECK(contains(words, "current carried to the ground (pA)"));
  // The lowest conductor carries three currents and the uppermost one: the two ends of viridis_r.
  run_without_error(folder, "plot scene.h5");
  CHECK(evaluate_picture(folder, "scene-frame-3-current.png", pixel(0.5 + 0.03, 0.55e-3 / 8e-3) + "[1]") < 0.1);
  CHECK(evaluate_picture(folder, "scene-frame-3-current.png", pixel(0.5 + 0.03, 2.65e-3 / 8e-3) + "[1]") > 0.8);
  for (const std::string colour : {"strahler", "connection_time"})
    run_without_error(folder, "plot scene.h5 --colour " + colour);
  const Ended old = run_program(folder, "plot scene.h5 --colour joined --overwrite");
  CHECK(old.status == 0);
  CHECK(contains(old.err, "--colour joined is an old name: it is called connection_time now"));
}

TEST_CASE("plot and run: existing pictures are replaced only with --overwrite") {
  const RunFolder folder(plates);
  run_without_error(folder, "plot scene.h5");
  check_refused(folder, "plot scene.h5",
                "scene-frame-5-potential.png exists: give --out another name, or give --overwrite");
  run_without_error(folder, "plot scene.h5 --overwrite");
  run_without_error(folder, "plot scene.h5 --series");
  check_refused(folder, "plot scene.h5 --series", "scene-series.png exists");
  fs::create_symlink(folder / "scene.toml", folder / "link.png");
  check_refused(folder, "plot scene.h5 --out link.png --overwrite", "link.png is no plain file");
  CHECK(text_of(folder / "scene.toml") == plates);
  // A run replaces only its own files.
  folder.write("other.toml", replaced(replaced(plates, "picture = false", ""), "time = 0.02", "time = 0.004"));
  folder.write("other.png", "mine");
  check_refused(folder, "run other.toml --quiet", "other.png exists, where the run writes its picture");
  CHECK(text_of(folder / "other.png") == "mine");
  CHECK_FALSE(fs::exists(folder / "other.h5"));
  run_without_error(folder, "run other.toml --quiet --overwrite");
  CHECK(text_of(folder / "other.png").starts_with("\x89PNG"));
}

TEST_CASE("plot, film and view: impossible requests are refused with a message") {
  const RunFolder folder(plates);
  check_refused(folder, "plot scene.h5 --range 5,-5", "--range 5,-5 is reversed");
  check_refused(folder, "plot scene.h5 --range 5", "--range 5 is not valid: it must be two numbers");
  check_refused(folder, "plot scene.h5 --range 0,inf", "both ends must be finite");
  check_refused(folder, "plot scene.h5 --colour force --range=-1,1", "force is drawn by decades, from above 0");
  check_refused(folder, "plot scene.h5 --colour cluster --range 0,1", "do not apply to the colour cluster");
  check_refused(folder, "plot scene.h5 --cmap rainbows", "--cmap rainbows is no colour map");
  check_refused(folder, "plot scene.h5 --colour current", "scene.h5 has no current by conductor");
  check_refused(folder, "plot scene.h5 --frame 6", "frame 6 is not in scene.h5: it has frames 0 to 5");
  check_refused(folder, "plot scene.h5 --frames 0,7", "frame 7 is not in scene.h5");
  check_refused(folder, "plot scene.h5 --frames 4:2", "4:2 is reversed");
  check_refused(folder, "plot scene.h5 --frames 0:5:0", "the step `0` must be a whole number from 1 on");
  check_refused(folder, "plot scene.h5 --frames first", "`first` is not a frame");
  check_refused(folder, "plot scene.h5 --frames 0,", "`` is not a frame");
  check_refused(folder, "plot scene.h5 --frame 1 --frames 2", "--frame and --frames say the same");
  check_refused(folder, "plot scene.h5 --out nowhere/a.png", "nowhere/a.png cannot be written: there is no folder");
  check_refused(folder, "plot scene.h5 --out a.gif", "its name must end in .png, .pdf or .svg");
  check_refused(folder, "plot scene.h5 --cut z=1", "--cut is for scenes in space");
  check_refused(folder, "plot scene.h5 --series --colour charge", "are for pictures of frames, not for curves");
  check_refused(folder, "plot scene.h5 --series --observables energy,volume", "scene has not recorded volume: it has ");
  check_refused(folder, "plot scene.h5 --observables energy", "it needs --series");
  check_refused(folder, "film scene.h5 --out a.avi", "films are written as .mp4");
  check_refused(folder, "film scene.h5 --rate 0", "--rate: 0 is not allowed: it must be a number above 0");
  check_refused(folder, "film scene.h5 --rate 1e-9", "--rate 1e-09 is not allowed: it must be from 0.1 to 1000");
  check_refused(folder, "film scene.h5 --frames 3:9", "frame 9 is not in scene.h5");
  check_refused(folder, "film scene.h5 --range 2,1", "--range 2,1 is reversed");
  CHECK_FALSE(fs::exists(folder / "scene.mp4"));
  REQUIRE(run_shell(folder, "mkfifo pipe.h5").status == 0);
  for (const char* command : {"plot", "film", "view", "export --to csv"})
    check_refused(folder, fmt::format("{} pipe.h5", command), "pipe.h5 is no file: name a result file");
  folder.write("scene.mp4", "mine");
  check_refused(folder, "film scene.h5", "scene.mp4 exists: give --out another name, or give --overwrite");
  const Ended without = run_shell(folder, "PATH=/nowhere LICHTENBERG film scene.h5 --overwrite");
  CHECK(without.status == 2);
  CHECK(contains(without.err, "there is no ffmpeg, which makes films of pictures: install Debian's package ffmpeg"));
  CHECK(text_of(folder / "scene.mp4") == "mine");
  // Another user owns this folder; root can write everywhere.
  if (std::system("test $(id -u) != 0") == 0)
    check_refused(folder, "plot scene.h5 --out /proc/a.png", "cannot be written");
}

TEST_CASE("plot, film, view: file names with a colon or leading dash are accepted") {
  const RunFolder folder(plates);
  REQUIRE(run_shell(folder, "cp scene.h5 a:b.h5; cp -- scene.h5 -c.h5").status == 0);
  for (const std::string name : {"a:b", "-c"}) {
    for (const std::string command : {"film --quiet", "plot", "plot --series --out series.png --overwrite", "view"}) {
      const Ended ended = run_shell(folder, fmt::format("LICHTENBERG {} -- {}.h5", command, name));
      CHECK_MESSAGE(ended.status == 0, command << " " << name << ": " << ended.err);
    }
    CHECK(fs::file_size(folder / (name + ".mp4")) > 0);
    CHECK(fs::file_size(folder / (name + ".html")) > 0);
  }
  const Ended named = run_shell(folder, "LICHTENBERG film scene.h5 --quiet --out=-d:e.mp4");
  CHECK_MESSAGE(named.status == 0, named.err);
  CHECK(fs::file_size(folder / "-d:e.mp4") > 0);
}

TEST_CASE("plot: an unknown MPLBACKEND in the environment is ignored") {
  const RunFolder folder(plates);
  for (const std::string command : {"plot scene.h5 --overwrite", "plot scene.h5 --series --overwrite"}) {
    const Ended ended = run_shell(folder, "MPLBACKEND=nonsense LICHTENBERG " + command);
    CHECK_MESSAGE(ended.status == 0, ended.err);
    CHECK_FALSE(contains(ended.err, "Traceback"));
  }
}

TEST_CASE("film: an interruption leaves no file and prints no traceback") {
  const RunFolder folder(plates);
  folder.write(
      "ffmpeg",
      "#!/bin/sh\n>scene.mp4.partial-$PPID\nhead -c 100000 >/dev/null\nkill -INT $PPID\nexec cat >ffmpeg.log\n");
  const Ended ended =
      run_shell(folder, "chmod +x ffmpeg; PATH=.:$PATH env --default-signal=INT LICHTENBERG film scene.h5 --quiet");
  CHECK(ended.status != 0);
  CHECK(ended.err.find("Traceback") == std::string::npos);
  CHECK_FALSE(fs::exists(folder / "scene.mp4"));
  CHECK(run_shell(folder, "ls | grep -c partial").out == "0\n");
}

TEST_CASE("plot --frames ::5: a range without ends covers all frames") {
  const RunFolder folder(plates);
  CHECK(run_without_error(folder, "plot scene.h5 --frames ::5 --out a.png").out ==
        "a-0.png shows frame 0 by potential\na-5.png shows frame 5 by potential\n");
}

TEST_CASE("film: each frame appears once, in the size of the picture") {
  const RunFolder folder(plates);
  const Ended made = run_without_error(folder, "film scene.h5 --rate 10");
  CHECK(made.out == "scene.mp4 shows 6 frames by potential in 0.6 s\n");
  const Ended probed = run_shell(folder,
                                 "ffprobe -v error -count_frames -select_streams v -show_entries "
                                 "stream=width,height,nb_read_frames,pix_fmt -of csv=p=0 scene.mp4");
  REQUIRE(probed.status == 0);
  CHECK(probed.out == "1060,1024,yuv420p,6\n");  // 6.24 x 6.02 inches at 170 points per inch, rounded to even numbers.
  // The film has the colours of the pictures.
  REQUIRE(run_shell(folder, "ffmpeg -v error -i scene.mp4 -frames:v 1 first.png").status == 0);
  CHECK(evaluate_picture(folder, "first.png", pixel(0.02, 0.9) + "[0]") > 0.3);
  CHECK(evaluate_picture(folder, "first.png", pixel(0.02, 0.9) + "[2]") < 0.25);
  run_without_error(folder, "film scene.h5 --frames 1::2 --colour charge --quiet");
  CHECK(run_shell(folder,
                  "ffprobe -v error -count_frames -show_entries stream=nb_read_frames -of csv=p=0 scene-charge.mp4")
            .out == "3\n");
}

TEST_CASE("plot: time series of several results, and pictures side by side") {
  const RunFolder folder(plates);
  fs::copy_file(folder / "scene.h5", folder / "twin.h5");
  run_without_error(folder, "plot scene.h5 --series --observables energy,charge_held --out curves.svg");
  CHECK(contains(text_of(folder / "curves.svg"), "charge held"));
  run_without_error(folder, "plot scene.h5 twin.h5 --series --out both.svg");
  CHECK(contains(text_of(folder / "both.svg"), "twin"));
  run_without_error(folder, "plot scene.h5 twin.h5");
  // Two panels of 4.2 inches with 0.35 between them, and margins of 0.22 and 1.02.
  CHECK(evaluate_picture(folder, "scene-beside-twin-frame-5-potential.png", "p.shape[1]") ==
        doctest::Approx(200 * 9.99).epsilon(1e-3));

  run_without_error(folder, "ensemble scene.toml --vary medium.viscosity=0.5,0.7 --seeds 2 --out many --quiet");
  run_without_error(folder, "plot many --series --out many.svg");
  CHECK(contains(text_of(folder / "many.svg"), "medium.viscosity = 0.5"));
  run_without_error(folder, "plot many --observables time,conductors --out means.svg");
  CHECK(contains(text_of(folder / "means.svg"), "medium.viscosity"));
  run_without_error(folder, "ensemble scene.toml --vary medium.viscosity=0.3,0.9 --out many --quiet");
  CHECK(contains(run_without_error(folder, "plot many/ensemble-2.json --observables time").out,
                 "many/ensemble-2-means-time.png"));
  check_refused(folder, "plot many --observables volume", "has no volume");
  check_refused(folder, "plot many/absent.json", "there is no many/absent.json");
}

TEST_CASE("plot: spheres in space hide each other, --cut removes the front") {
  const RunFolder folder(R"(
[domain]
size = [10.0, 10.0, 10.0]
[[conductor]]
position = [5.0, 5.0, 8.0]
radius = 1.9
[[conductor]]
position = [2.3, 3.15, 2.96]
velocity = [1.0, 0.0, 0.0]
radius = 1.0
[effects.hertz_contact]
[output]
every = 1e-3
picture = false
[stop]
time = 1e-3
stationary = false
)");
  run_without_error(folder, "plot scene.h5 --frame 0 --colour speed");
  run_without_error(folder, "plot scene.h5 --frame 0 --colour speed --cut z=5");
  const std::string both = "scene-frame-0-speed.png", cut = "scene-frame-0-speed-cut-z-5.png";
  // The moving sphere is purple, one end of the colour map. The sphere at rest in front of it is pale.
  const std::string purple = "(p[..., 2] > p[..., 1] + .08)[:, :1000].sum()";
  CHECK(evaluate_picture(folder, cut, purple) > 3000);
  CHECK(evaluate_picture(folder, both, purple) == 0);
  check_refused(folder, "plot scene.h5 --cut z=11", "--cut z=11 leaves nothing: the box reaches from z = 0 to 10 m");
  check_refused(folder, "plot scene.h5 --cut w=1", "it must be an axis and a position on it");
}

}  // namespace pictures_test
