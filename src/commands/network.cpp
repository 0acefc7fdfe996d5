#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "solvers/error.hpp"
#include "solvers/network/electrode.hpp"
#include "solvers/network/resistor.hpp"
#include "src/commands/commands.hpp"
#include "src/commands/json_output.hpp"
#include "src/commands/output.hpp"
#include "src/commands/packing_network.hpp"
#include "src/commands/progress.hpp"
#include "src/commands/python.hpp"
#include "src/commands/reading.hpp"

namespace lichtenberg {
namespace {

struct NetworkArguments {
  std::string file, picture;
  std::optional<int> frame;
  NetworkOptions options;  ///< given options, except for the model
  std::optional<std::string> model;
  std::optional<std::string> between;
  std::optional<double> voltage;
  JsonTarget json;
  bool no_picture = false, no_save = false, overwrite = false, quiet = false, loads = false;
};

/// Merges options: those of the command line override the scene's, key by key. The scene's parameters belong to its own
/// resistor model; another model ignores parameters that it does not use.
NetworkOptions options_for(const NetworkArguments& request, const Scene& scene) {
  NetworkOptions options = scene.network;
  if (request.model) options.model = value_of<NetworkModel>(*request.model);
  if (request.options.resistor) options.resistor = request.options.resistor;
  if (request.between) options.between = *request.between;
  const network::ResistorModel& resistor = network::resistor_model(options.resistor.value_or("constant"));
  for (const network::ParameterEntry& entry : network::parameter_entries()) {
    if (!network::needs(resistor, entry)) (options.parameters.*entry.value).reset();
    if (const auto& value = request.options.parameters.*entry.value) options.parameters.*entry.value = value;
  }
  return options;
}

std::vector<NetworkModel> models_of(const NetworkOptions& options) {
  if (options.model) return {*options.model};
  const network::ResistorModel& resistor = network::resistor_model(options.resistor.value_or("constant"));
  if (resistor.path == nullptr) return {NetworkModel::contact};
  return {NetworkModel::particle, NetworkModel::contact};
}

std::string resistor_in_words(const NetworkOptions& options) {
  const network::ResistorModel& model = network::resistor_model(options.resistor.value_or("constant"));
  std::string words = model.name;
  for (const network::ParameterEntry& entry : network::parameter_entries())
    if (options.parameters.*entry.value)
      words += fmt::format(", {} = {:g} {}", entry.name, *(options.parameters.*entry.value), entry.unit);
  return words;
}

std::string assumed_in_words(bool assumed) {
  return assumed ? ": assumed, since neither --resistor nor [network] names a model" : "";
}

/// Returns the physical assumption behind a network model.
std::string meaning_of(NetworkModel model, const NetworkOptions& options) {
  const std::string resistor = options.resistor.value_or("constant");
  if (network::resistor_model(resistor).contacts_only)
    return "contacts resist and particles do not: either network has the same resistance";
  if (model == NetworkModel::particle) return "contacts resist, and particles hardly do";
  if (resistor == "disk" || resistor == "sphere") return "particles resist, and contacts are small";
  return "particles resist, and contacts do not; a resistor for each pair of a particle's contacts, so that many "
         "contacts conduct better than in a solid (disk, sphere)";
}

/// Formats the count and the first few numbers.
std::string list_in_words(const std::vector<int>& numbers) {
  constexpr std::size_t most = 12;
  const std::vector<int> few(numbers.begin(), numbers.begin() + std::min(most, numbers.size()));
  if (numbers.empty()) return "none";
  return fmt::format("{}: {}{}", numbers.size(), fmt::join(few, " "), numbers.size() > most ? " ..." : "");
}

void print_table(const SolvedNetwork& solved) {
  const network::Conduction& c = solved.conduction;
  fmt::print("{}-centred network of particles whose surfaces touch or overlap\n", name_of(solved.model));
  fmt::print("  right where           {}\n", meaning_of(solved.model, solved.options));
  fmt::print("  resistor              {}{}\n", resistor_in_words(solved.options), assumed_in_words(solved.assumed));
  fmt::print("  nodes, resistors      {}, {}\n", solved.network.network.nodes, solved.network.network.links.size());
  if (!c.connected) {
    fmt::print("  effective resistance  infinite: no path of contacts leads from one electrode to the other\n");
  } else {
    fmt::print("  effective resistance  {:.12g} Ohm\n", c.resistance);
    fmt::print("  current               {:.12g} A\n", c.current);
    fmt::print("  dissipated power      {:.12g} W, sum of i^2 r; deviation from V^2/R: {:.1g}\n", c.power,
               c.power_balance);
  }
  fmt::print("  backbone particles    {}\n", list_in_words(solved.backbone));
  fmt::print("  dead ends             {}\n", list_in_words(solved.dead_ends));
  fmt::print("  isolated particles    {}\n", list_in_words(solved.isolated));
}

void print_tables(const std::vector<SolvedNetwork>& networks, const std::string& why_no_contact) {
  for (const SolvedNetwork& solved : networks) print_table(solved);
  if (!why_no_contact.empty()) fmt::print("contact-centred network: none, since {}\n", why_no_contact);
}

/// Describes the model of a SolvedNetwork or ResistancesToAll. Infinity and NaN are written as null.
template <class Solution>
nlohmann::ordered_json model_json(const Solution& found) {
  nlohmann::ordered_json json = {{"model", name_of(found.model)},
                                 {"resistor", found.options.resistor.value_or("constant")},
                                 {"parameters", nlohmann::ordered_json::object()},
                                 {"assumed", found.assumed},
                                 {"right_where", meaning_of(found.model, found.options)}};
  for (const network::ParameterEntry& entry : network::parameter_entries())
    if (const auto& value = found.options.parameters.*entry.value) json["parameters"][entry.name] = *value;
  return json;
}

nlohmann::ordered_json network_json(const SolvedNetwork& solved) {
  const network::Conduction& c = solved.conduction;
  nlohmann::ordered_json json = model_json(solved);
  json.update({{"between", solved.options.between},
               {"connected", c.connected},
               {"resistance", c.resistance},
               {"conductance", c.conductance},
               {"current", c.current},
               {"power", c.power},
               {"power_balance", c.power_balance},
               {"electrodes", solved.network.electrode},
               {"potential", c.potential},
               {"links", nlohmann::ordered_json::array()},
               {"backbone", solved.backbone},
               {"dead_ends", solved.dead_ends},
               {"isolated", solved.isolated}});
  for (std::size_t k = 0; k < c.link_current.size(); ++k) {
    const network::Link& link = solved.network.network.links[k];
    json["links"].push_back({{"nodes", {link.a, link.b}},
                             {"conductance", link.conductance},
                             {"current", c.link_current[k]},
                             {"power", c.link_current[k] * c.link_current[k] / link.conductance}});
  }
  return json;
}

nlohmann::ordered_json json_of(const NetworkArguments& request, const PackingFrame& frame,
                               const std::vector<SolvedNetwork>& networks, const std::string& why_no_contact) {
  nlohmann::ordered_json json = {{"file", request.file},
                                 {"frame", frame.frame},
                                 {"particles", frame.packing.size()},
                                 {"voltage", request.voltage.value_or(1)},
                                 {"warnings", frame.warnings},
                                 {"networks", nlohmann::ordered_json::array()}};
  for (const SolvedNetwork& solved : networks) json["networks"].push_back(network_json(solved));
  if (!why_no_contact.empty()) json["no_contact_network"] = why_no_contact;
  return json;
}

// One electrode to all particles.

/// Returns the electrode of `--terminals ELECTRODE,all`; empty for other values.
std::optional<std::string> one_to_all(const NetworkArguments& request) {
  const std::string between = request.between.value_or("");
  const std::size_t comma = between.rfind(',');
  if (comma == std::string::npos) return {};
  std::string second = between.substr(comma + 1);
  std::erase(second, ' ');
  return second == network::all_particles ? std::optional(between.substr(0, comma)) : std::nullopt;
}

std::string resistance_in_words(double resistance) {
  if (std::isnan(resistance)) return "touches";
  return std::isinf(resistance) ? "infinite" : fmt::format("{:.12g}", resistance);
}

void print_table(const std::vector<ResistancesToAll>& found) {
  for (const ResistancesToAll& each : found) {
    fmt::print("# {}-centred: right where {}\n", name_of(each.model), meaning_of(each.model, each.options));
    fmt::print("# resistor {}{}\n", resistor_in_words(each.options), assumed_in_words(each.assumed));
    if (std::ranges::any_of(each.resistance, [](double r) { return std::isnan(r); }))
      fmt::print("# touches: the contact with the electrode would have to be at both potentials\n");
  }
  const std::string& electrode = found.front().options.between;
  fmt::print("# resistance in Ohm from {} {} to each particle\nparticle",
             network::is_electrode_name(electrode) ? "wall" : "particle", electrode);
  for (const ResistancesToAll& each : found) fmt::print("  {:>20}", name_of(each.model) + "-centred");
  for (std::size_t i = 0; i < found.front().resistance.size(); ++i) {
    fmt::print("\n{:8}", i);
    for (const ResistancesToAll& each : found) fmt::print("  {:>20}", resistance_in_words(each.resistance[i]));
  }
  fmt::print("\n");
}

nlohmann::ordered_json json_of(const NetworkArguments& request, const PackingFrame& frame,
                               const std::vector<ResistancesToAll>& found) {
  nlohmann::ordered_json json = {{"file", request.file},
                                 {"frame", frame.frame},
                                 {"particles", frame.packing.size()},
                                 {"warnings", frame.warnings},
                                 {"networks", nlohmann::ordered_json::array()}};
  for (const ResistancesToAll& each : found) {
    nlohmann::ordered_json one = model_json(each);
    one.update({{"from", each.options.between},
                {"resistance", each.resistance},
                {"touching", nlohmann::ordered_json::array()}});
    for (std::size_t i = 0; i < each.resistance.size(); ++i)
      if (std::isnan(each.resistance[i])) one["touching"].push_back(i);
    json["networks"].push_back(one);
  }
  return json;
}

void check_one_to_all(const NetworkArguments& request) {
  const auto refuse = [](const std::string& option) {
    throw InputError(
        fmt::format("option {} is not allowed with --terminals ELECTRODE,all, which prints resistances and neither "
                    "draws nor stores anything",
                    option));
  };
  if (request.voltage) refuse("--voltage");
  if (!request.picture.empty()) refuse("--out");
  if (request.overwrite && request.json.file().empty()) refuse("--overwrite");
}

/// Computes the resistances and shows progress if that takes more than two seconds.
std::vector<ResistancesToAll> resistances_with_progress(const PackingFrame& frame, const NetworkOptions& options,
                                                        bool quiet) {
  constexpr double moment = 2;  // s
  const auto began = std::chrono::steady_clock::now();
  Progress progress(0, frame.packing.size(), quiet);
  const auto show = [&](int done) {
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() > moment && progress.due())
      progress.show(fmt::format("{} of {} particles", done, frame.packing.size()), done);
  };
  std::vector<ResistancesToAll> found;
  for (const NetworkModel model : models_of(options)) found.push_back(resistances_to_all(frame, model, options, show));
  return found;
}

void measure_to_all(const NetworkArguments& request, const std::string& electrode) {
  check_one_to_all(request);
  check_outputs({request.json.file()}, {request.file}, request.overwrite);
  const PackingFrame frame = read_packing(request.file, request.frame);
  warn_if_changed(*frame.file);
  NetworkOptions options = options_for(request, frame.scene);
  options.between = electrode;
  const std::vector<ResistancesToAll> found = resistances_with_progress(frame, options, request.quiet);
  if (!request.json.printed()) print_table(found);
  if (!request.json.word.empty()) request.json.put(json_of(request, frame, found), 2);
  print_warnings(frame.warnings);
}

// Each load of a packing.

void check_measure_loads(const NetworkArguments& request) {
  const auto refuse = [](const std::string& option) {
    throw InputError(
        fmt::format("option {} is not allowed with --loads, which prints resistances and neither draws nor stores "
                    "anything",
                    option));
  };
  if (request.frame) refuse("--frame");
  if (request.voltage) refuse("--voltage");
  if (!request.picture.empty()) refuse("--out");
  if (one_to_all(request)) refuse("--terminals ELECTRODE,all");
  if (request.overwrite && request.json.file().empty()) refuse("--overwrite");
}

/// Returns the networks of a packing between two electrodes, at 1 V. A contact-centred network that does
/// not exist is left out, unless it is requested.
std::vector<SolvedNetwork> solve_networks(const PackingFrame& frame, const NetworkOptions& options) {
  std::vector<SolvedNetwork> networks;
  for (const NetworkModel model : models_of(options))
    if (options.model || model == NetworkModel::particle || contact_network_obstacle(frame, options).empty())
      networks.push_back(solve_network(frame, model, options, 1));
  return networks;
}

nlohmann::ordered_json load_json(const Load& load, const std::vector<SolvedNetwork>& networks) {
  nlohmann::ordered_json json = {{"frame", load.frame},
                                 {"packing_fraction", load.packing_fraction},
                                 {"pressure", load.pressure},
                                 {"networks", nlohmann::ordered_json::array()}};
  for (const SolvedNetwork& solved : networks) {
    nlohmann::ordered_json one = model_json(solved);
    one.update({{"between", solved.options.between},
                {"connected", solved.conduction.connected},
                {"resistance", solved.conduction.resistance}});
    json["networks"].push_back(one);
  }
  return json;
}

/// Prints the resistances of the networks at each load.
void measure_loads(const NetworkArguments& request) {
  check_measure_loads(request);
  check_outputs({request.json.file()}, {request.file}, request.overwrite);
  nlohmann::ordered_json json = {{"file", request.file}, {"loads", nlohmann::ordered_json::array()}};
  std::string header, lines;
  std::vector<std::string> warnings;
  for (const Load& load : read_loads(request.file)) {
    const PackingFrame frame = read_packing(request.file, load.frame);
    const std::vector<SolvedNetwork> networks = solve_networks(frame, options_for(request, frame.scene));
    json["loads"].push_back(load_json(load, networks));
    const SolvedNetwork& first = networks.front();
    header = fmt::format("# resistor {}{}\n# resistance in Ohm between {}\n# load  packing_fraction  pressure in {}",
                         resistor_in_words(first.options), assumed_in_words(first.assumed), first.options.between,
                         frame.scene.dimension() == 3 ? "Pa" : "N/m");
    lines += fmt::format("\n{:6}  {:16.12f}  {:15.9g}", load.frame, load.packing_fraction, load.pressure);
    for (const SolvedNetwork& solved : networks) {
      header += fmt::format("  {:>20}", name_of(solved.model) + "-centred");
      lines += fmt::format("  {:>20}", resistance_in_words(solved.conduction.resistance));
    }
    warnings = frame.warnings;
  }
  if (!request.json.printed()) fmt::print("{}{}\n", header, lines);
  json["warnings"] = warnings;
  request.json.put(json, 2);
  print_warnings(warnings);
}

// Two electrodes.

bool draws(const NetworkArguments& request) { return !request.no_picture && !request.no_save; }

/// Returns the file name of the picture, which contains the options that were given.
std::string picture_of(const NetworkArguments& request) {
  if (!request.picture.empty()) return request.picture;
  std::filesystem::path picture = request.file;
  std::string name = picture.stem().string() + "-network";
  if (request.model) name += "-" + *request.model;
  if (request.options.resistor) name += "-" + *request.options.resistor;
  if (request.between) name += "-" + *request.between;
  if (request.frame) name += fmt::format("-frame-{}", *request.frame);
  std::ranges::replace(name, ',', '-');
  return picture.replace_filename(name + ".png").string();
}

void draw_networks(const NetworkArguments& request, const std::vector<std::string>& warnings,
                   const std::vector<SolvedNetwork>& networks) {
  std::string models;
  for (const SolvedNetwork& solved : networks)
    models += (models.empty() ? "" : ",") + std::string(name_of(solved.model));
  std::vector<std::string> words = {request.file, picture_of(request), models};
  words.insert(words.end(), warnings.begin(), warnings.end());
  draw("network.draw_file", words);
}

void measure(const NetworkArguments& request) {
  read_in_child({request.file});
  if (request.loads) return measure_loads(request);
  if (const std::optional<std::string> electrode = one_to_all(request)) return measure_to_all(request, *electrode);
  check_overwrite(request.overwrite, {request.json.file(), draws(request) ? picture_of(request) : ""},
                  "a picture or --json=FILE");
  constexpr double least = 1e-100, most = 1e100;  // keeps the square finite
  const double voltage = request.voltage.value_or(1);
  if (!(voltage >= least && voltage <= most))
    throw InputError(
        fmt::format("--voltage {:g} is not allowed: it must be from {:g} to {:g} V", voltage, least, most));
  const PackingFrame frame = read_packing(request.file, request.frame);
  warn_if_changed(*frame.file);
  if (!request.no_save) check_writable(request.file);
  if (draws(request)) check_output("--out", picture_of(request), request.overwrite);
  check_outputs({request.json.file(), draws(request) ? picture_of(request) : ""}, {request.file}, request.overwrite);
  const NetworkOptions options = options_for(request, frame.scene);
  std::vector<NetworkModel> models = models_of(options);
  std::string why_no_contact;
  if (models.size() > 1) why_no_contact = contact_network_obstacle(frame, options);
  if (!why_no_contact.empty()) models = {NetworkModel::particle};
  std::vector<SolvedNetwork> networks;
  for (const NetworkModel model : models) networks.push_back(solve_network(frame, model, options, voltage));
  if (!request.no_save) save_networks(request.file, frame, networks, !why_no_contact.empty());
  if (!request.json.printed()) print_tables(networks, why_no_contact);
  if (!request.json.word.empty()) request.json.put(json_of(request, frame, networks, why_no_contact), 2);
  if (draws(request)) draw_networks(request, frame.warnings, networks);
  print_warnings(frame.warnings);
}

}  // namespace

Command network_command() {
  auto request = std::make_shared<NetworkArguments>();
  Command command{"network", "Measures the resistance of a result file's particles in contact"};
  std::vector<std::string> resistors;
  for (const network::ResistorModel& model : network::resistor_models()) resistors.push_back(model.name);
  command.arguments = {
      {"RESULT", &request->file, "result file of a run (.h5); the networks are stored in it", {.required = true}},
      {"--model",
       &request->model,
       "nodes of the network: `particle` if contacts resist, `contact` if the particles themselves do (default: "
       "network.model of the scene, or both)",
       {.allowed = names_of<NetworkModel>()}},
      {"--terminals", &request->between,
       "electrodes, the first at 0 V: names of walls or numbers of particles (default: network.terminals of the "
       "scene, or bottom,top); 0,all prints the resistances from particle 0 to each particle"},
      {"--resistor",
       &request->options.resistor,
       "model of a resistor (default: network.resistor of the scene, or constant, of 1 Ohm)",
       {.allowed = resistors}}};
  for (const network::ParameterEntry& entry : network::parameter_entries()) {
    std::string option = fmt::format("--{}", entry.name);
    std::ranges::replace(option, '_', '-');
    command.arguments.push_back(
        {option, &(request->options.parameters.*entry.value), fmt::format("{}, in {}", entry.help, entry.unit)});
  }
  command.arguments.insert(
      command.arguments.end(),
      {{"--voltage", &request->voltage, "voltage of the second electrode, in V (default: 1)"},
       frame_argument(request->frame),
       {"--loads", &request->loads, "print the resistance at each load of a packing ([compression] of the scene)"},
       {"--out", &request->picture,
        "picture to write, .png, .pdf or .svg (default: RESULT-network.png, with the given options in its name)"},
       overwrite_argument(request->overwrite),
       quiet_argument(request->quiet),
       {"--no-picture", &request->no_picture, "draw nothing"},
       {"--no-save", &request->no_save, "do not change the result file; draws nothing"},
       json_argument(request->json, "SI units, every node and resistor")});
  command.act = [request] { measure(*request); };
  return command;
}

}  // namespace lichtenberg
