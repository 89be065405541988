/// The base of every module: small value types, outcomes, columns, parallel loops, mesh values and their topology.
export module camber.core;
export import :vec;
export import :sym;
export import :outcome;
export import :option;
export import :words;
export import :guarded;
export import :ids;
export import :column;
export import :execution;
export import :each;
export import :mesh;
export import :maps;
export import :required;
export import :scale;
export import :topology;
export import :box_tree;
