/// Pipelines: a config's stages over mesh values, and the report of what they did.
export module camber.run;
export import :inspection;
export import :measurements;
export import :page;
export import :pipeline;
export import :report;
export import :stages;
