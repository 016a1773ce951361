#pragma once

/// The subcommands of `hoodoo`, one function each. They print to stdout, and throw Error.
namespace CLI {
class App;
}
namespace hoodoo {

/// Each adds its subcommand to `app`; when it is chosen, `*exit` becomes the exit code.
void add_bake(CLI::App& app, int* exit);
void add_merge(CLI::App& app, int* exit);
void add_check(CLI::App& app, int* exit);
void add_verify(CLI::App& app, int* exit);
void add_diff(CLI::App& app, int* exit);
void add_export(CLI::App& app, int* exit);
void add_generate(CLI::App& app, int* exit);
void add_info(CLI::App& app, int* exit);
void add_analyze(CLI::App& app, int* exit);
void add_probe(CLI::App& app, int* exit);
void add_schema(CLI::App& app, int* exit);
void add_draw(CLI::App& app, int* exit);
void add_synthesize(CLI::App& app, int* exit);
void add_serve(CLI::App& app, int* exit);
void add_key(CLI::App& app, int* exit);

/// `--json` was given: results and errors are JSON.
bool json_wanted(const CLI::App& app);

}  // namespace hoodoo
