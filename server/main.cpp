#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <exception>
#include <nlohmann/json.hpp>
#include <system_error>

#include "engine/base/error.hpp"
#include "engine/base/simd.hpp"
#include "server/commands.hpp"
#include "server/job/state.hpp"
#include "tiling/slice/slice.hpp"

namespace hoodoo {
namespace {

/// The one place that knows exit codes (DESIGN section 8).
int exit_code(Fault fault) {
  switch (fault) {
    case Fault::bad_input:
      return 2;
    case Fault::limit:
      return 3;
    case Fault::not_found:
    case Fault::io:
      return 4;
    case Fault::cancelled:
      return 130;
    case Fault::internal:
      break;
  }
  return 5;
}

int tell(const Error& error, bool as_json) {
  if (as_json) {
    nlohmann::json problems = nlohmann::json::array();
    for (const auto& p : error.problems) problems.push_back({{"where", p.where}, {"what", p.what}});
    const nlohmann::json text = {{"exit", exit_code(error.fault)},
                                 {"fault", job::name_of(error.fault)},
                                 {"problems", problems}};
    fmt::print(stderr, "{}\n", text.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    return exit_code(error.fault);
  }
  for (const auto& p : error.problems) {
    fmt::print(stderr, "hoodoo: {}{}{}\n", p.where, p.where.empty() ? "" : ": ", p.what);
  }
  return exit_code(error.fault);
}

int run(int argc, char** argv) {
  CLI::App app("hoodoo bakes terrain with caves, arches and overhangs into 3D Tiles");
  app.set_version_flag("--version", std::string(slice::engine_version()));
  app.add_flag("--json")->description("Results and errors as JSON");
  app.require_subcommand(1);
  app.fallthrough();
  int exit = 0;
  add_bake(app, &exit);
  add_merge(app, &exit);
  add_check(app, &exit);
  add_serve(app, &exit);
  add_key(app, &exit);
  add_verify(app, &exit);
  add_diff(app, &exit);
  add_export(app, &exit);
  add_analyze(app, &exit);
  add_generate(app, &exit);
  add_info(app, &exit);
  add_probe(app, &exit);
  add_schema(app, &exit);
  add_draw(app, &exit);
  add_synthesize(app, &exit);
  try {
    if (const char* simd = std::getenv("HOODOO_SIMD")) limit_simd(simd, "HOODOO_SIMD");
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : exit_code(Fault::bad_input);
  } catch (const Error& error) {
    return tell(error, json_wanted(app));
  } catch (const std::bad_alloc&) {
    return tell({Fault::limit, "", "out of memory"}, json_wanted(app));
  } catch (const std::system_error& error) {
    const bool short_of = error.code() == std::errc::resource_unavailable_try_again;
    return tell({short_of ? Fault::limit : Fault::internal, "", error.what()}, json_wanted(app));
  } catch (const std::exception& error) {
    return tell({Fault::internal, "", error.what()}, json_wanted(app));
  }
  return exit;
}

}  // namespace

bool json_wanted(const CLI::App& app) { return app.count("--json") > 0; }

}  // namespace hoodoo

int main(int argc, char** argv) { return hoodoo::run(argc, argv); }
