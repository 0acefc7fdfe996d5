#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>

#include "solvers/error.hpp"
#include "src/commands/commands.hpp"
#include "src/effects/read_scene.hpp"
#include "src/scene/nearest.hpp"
#include "src/scene/scene.hpp"

namespace lichtenberg {
namespace {

std::string help_text(const CLI::App& program, const std::string& topic) {
  // Not program.help(): that would pass the question on to the subcommand that was given, which is this one.
  if (topic.empty())
    return program.get_formatter()->make_help(&program, program.get_name(), CLI::AppFormatMode::Normal);
  if (topic == "scene") return scene_help();
  std::vector<std::string> topics{"scene"};
  for (const CLI::App* command : program.get_subcommands({})) {
    if (command->get_name() == topic) return command->help(program.get_name());
    topics.push_back(command->get_name());
  }
  throw InputError(fmt::format("there is no help on `{}`; did you mean `{}`? The topics are {}", topic,
                               nearest(topic, topics), fmt::join(topics, ", ")));
}

}  // namespace

void add_help(CLI::App& program) {
  CLI::App* command =
      program.add_subcommand("help", "Explains a command, or with `help scene` every key of a scene file");
  auto topic = std::make_shared<std::string>();
  command->add_option("TOPIC", *topic, "a command, or scene");
  command->callback([&program, topic] { fmt::print("{}", help_text(program, *topic)); });
}

}  // namespace lichtenberg
