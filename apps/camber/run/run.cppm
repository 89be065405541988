/// Pipelines: a config's stages over mesh values, and the report of what they did.
export module camber.run;
export import :fields;
export import :histogram;
export import :memory;
export import :report;
export import :order;
export import :pipeline;
export import :runner;
export import :plan;
export import :plot;
export import :check;
import :check_parts;
import :measures;
import :parts;
import :rows;
export import :stages;
import :state;
import :steps;
