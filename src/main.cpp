#include "src/commands/command_line.hpp"

int main(int argc, char** argv) { return lichtenberg::run_command_line({argv + 1, argv + argc}); }
