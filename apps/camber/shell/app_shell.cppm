/// What touches the system: files, terminal, clocks, memory and signals.
export module camber.app_shell;
export import :child;
export import :command;
export import :command_line;
export import :files;
export import :mapped_file;
export import :shared_file;
export import :interrupt;
export import :memory;
export import :meter;
export import :progress;
export import :stack;
export import :standard_output;
export import :terminal;
export import :voice;
