/// Runs on mesh values: a pipeline is a list of steps over one state. `run_pipeline` runs any list.
export module camber.recipes;
export import camber.stages;
export import :boundary_report;
export import :cycles;
export import :check;
export import :fields;
export import :inspection;
export import :measurements;
export import :report;
export import :run;
export import :state;
export import :step_reports;
export import :values;
